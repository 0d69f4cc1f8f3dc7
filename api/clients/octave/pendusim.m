function [phi, phid, lambda, stats, answer] = pendusim(L, m, S, phi0, phid0, t, varargin)
% PENDUSIM  The motion of a planar pendulum tree, as in the paper, computed by a pendulumd server.
%
%   [phi, phid] = pendusim(L, m, S, phi0, phid0, t)
%   [phi, phid, lambda, stats] = pendusim(..., 'method', 'ode23', 'rtol', 1e-6)
%
%   L, m         lengths (m) and masses (kg) of the n arms
%   S            connectivity matrix, n x n
%   phi0, phid0  angles from the positive real axis (rad) and their rates (rad/s) at t(1)
%   t            N instants (s), ascending or descending
%
%   phi, phid, lambda  n x N: angles, rates, compression forces (N). Columns are the instants.
%   stats              statistics of the computation, and the time up to which it is accurate (stats.horizon)
%   A fifth result has the whole answer, with instants as rows: with 'output', {'phi', 'z'} also the positions of the tips.
%
%   Options are any fields of POST /v1/trajectories, by name and value; 'method' is 'taylor' by default; the paper uses
%   'ode23'. Fields of the pendulum itself go into 'pendulum': struct('gravity', 1.62), or of a real pendulum
%   struct('damping', [0.1; 0.2], ...), one number per arm ({0.1} for one arm). Besides: 'url' and 'token' of the server
%   (or PENDULUM_URL and PENDULUM_TOKEN of the environment), 'patience' (60 s), 'progress' (true or false), and
%
%   id = pendusim(..., 'job', true)           lets the server compute it in the background
%   [phi, phid, lambda, stats] = pendusim(id) waits for it; options of PENDUASK may follow: pendusim(id, 'url', url)
%
%   See also PENDUASK, PENDUJOB.
if ischar(L) % the id of a job, and options
    options = varargin;
    given = {'m', 'S', 'phi0', 'phid0', 't'};
    rest = cell(1, nargin - 1 - numel(varargin));
    for k = 1:numel(rest)
        rest{k} = eval(given{k});
    end
    answer = pendujob(L, 'result', rest{:}, options{:});
else
    if nargin < 6
        error('pendusim:size', 'pendusim takes L, m, S, phi0, phid0 and t, the instants: pendusim(L, m, S, phi0, phid0, 0:.01:5)');
    end
    if mod(numel(varargin), 2) || ~all(cellfun(@ischar, varargin(1:2:end)))
        error('pendusim:option', 'options are pairs of a name and a value, as ''rtol'', 1e-6');
    end
    n = numel(L);
    if ~isequal(size(S), [n n]) || numel(m) ~= n || numel(phi0) ~= n || numel(phid0) ~= n
        error('pendusim:size', 'L has %d arms: m, phi0 and phid0 need as many, and S as many rows and columns', n);
    end
    % cells of numbers are arrays in JSON, even with one of them
    pendulum = struct('L', {num2cell(L(:).')}, 'm', {num2cell(m(:).')}, 'S', {arrayfun(@(k) num2cell(S(k, :)), 1:n, 'UniformOutput', false)});
    request = struct('initial', struct('phi', {num2cell(phi0(:).')}, 'phid', {num2cell(phid0(:).')}), 'times', {instants(t)});
    options = {};
    for k = 1:2:numel(varargin)
        if any(strcmp(varargin{k}, {'url', 'token', 'patience', 'progress', 'job', 'title'}))
            options(end + 1:end + 2) = varargin(k:k + 1);
        elseif strcmp(varargin{k}, 'pendulum')
            more = fieldnames(varargin{k + 1}).';
            if ~all(strcmp(more, 'gravity'))
                pendulum = struct('length', {pendulum.L}, 'mass', {pendulum.m}, 'parent', {num2cell(parents(S))});
            end
            for name = more
                pendulum.(name{1}) = varargin{k + 1}.(name{1});
            end
        else
            request.(varargin{k}) = varargin{k + 1};
        end
    end
    request.pendulum = pendulum;
    answer = penduask('trajectories', request, options{:});
    if ischar(answer)
        phi = answer; % a job's id
        return
    end
end
phi = column(answer, 'phi');
phid = column(answer, 'phid');
lambda = column(answer, 'lambda');
stats = answer.stats;
stats.warnings = {};
if isfield(answer, 'warnings')
    stats.warnings = answer.warnings;
end
end

function parent = parents(S)
% the parent of each arm, 0 = the pivot: among the arms on its path, the one with the longest path. Real pendulums need it.
parent = zeros(1, size(S, 1));
for k = 1:size(S, 1)
    way = S(k, :) ~= 0;
    [~, parent(k)] = max(sum(S ~= 0, 2).' .* way .* ((1:numel(way)) ~= k));
    before = zeros(1, numel(way));
    if sum(way) == 1
        parent(k) = 0;
    else
        before = S(parent(k), :);
    end
    if ~isequal(S(k, :), before + ((1:numel(way)) == k))
        error('pendusim:S', 'row %d of S is not the path from the pivot to tip %d', k, k);
    end
end
end

function times = instants(t)
% many evenly spaced instants as start, stop and count; others unchanged
t = double(t(:).');
even = linspace(t(1), t(end), numel(t));
if numel(t) > 20000 && all(abs(t - even) <= 4 * eps(max(abs(t))))
    times = struct('start', t(1), 'stop', t(end), 'count', numel(t));
else
    times = num2cell(t);
end
end

function value = column(answer, name)
% columns are the instants; empty if 'output' omits it
value = [];
if isfield(answer, name)
    value = answer.(name).';
end
end
