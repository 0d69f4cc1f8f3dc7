% The Octave client against a live server: the paper's call, options, jobs, refusals, lines that break.
% usage: octave-cli client.m FOLDER REFERENCE FRONT BROKEN OUT     (of the client; tests/golden/paper_example.txt; a front that refuses
% twice; one that cuts downloads; a file for the doubles of the paper's example; a server of pages;
% perhaps a url that hears of a job's end)
% Leaves to others: counting (test_octave.py). Invariant: every check says ok or FAIL with its name.
1;
function check(name, good)
    words = {'FAIL', 'ok'};
    printf('%s %s\n', words{1 + all(good(:))}, name);
end
function refused(name, words, varargin)
    try
        pendusim(varargin{:});
        check(name, false);
    catch problem
        check([name ': ' strrep(problem.message, "\n", ' ')], ! isempty(strfind(problem.message, words)));
    end
end
arguments = argv();
addpath(arguments{1});
warning('off', 'pendusim:accuracy');

% the paper's example, unchanged
L = [2; 1.5; 0.75; 1.25]; m = [1; 1; 1; 0.1]; S = [1 0 0 0; 1 1 0 0; 1 1 1 0; 1 1 0 1];
phi0 = zeros(4, 1); phid0 = zeros(4, 1);
t = 0:.01:5;
[phi, phid] = pendusim(L, m, S, phi0, phid0, t);
reference = dlmread(arguments{2}, ' ', 2, 0).';
check('n x N, columns are the instants', isequal(size(phi), [4 501]) && isequal(size(phid), [4 501]));
check('angles of the reference', abs(phi(:, 1:10:end) - reference(2:5, :)) < 1e-8);
check('rates of the reference', abs(phid(:, 1:10:end) - reference(6:9, :)) < 1e-6);
[phi2, phid2, lambda, stats] = pendusim(L, m, S, phi0, phid0, t, 'rtol', 1e-12);
check('forces of the reference', abs(lambda(:, 1:10:end) - reference(10:13, :)) < 1e-4);
check('statistics', strcmp(stats.method, 'taylor') && stats.horizon == 5 && isempty(stats.warnings) && isequal(phi2, phi));
[coarse, ~, ~, stats] = pendusim(L, m, S, phi0, phid0, t, 'method', 'ode23');
off = max(abs(coarse(:, end) - phi(:, end)));
check('ode23 is off as in the paper', strcmp(stats.method, 'ode23') && off > 0.01 && off < 0.5 && numel(stats.warnings) == 1);
[~, ~, ~, ~, answer] = pendusim(L, m, S, phi0, phid0, t, 'output', {'phi', 'z'});
check('positions', abs(answer.z.' - S * diag(L) * exp(1i * phi)) < 1e-9);
[~, phid, lambda] = pendusim(L, m, S, phi0, phid0, t, 'output', {'phi'});
check('what is left out is empty', isempty(phid) && isempty(lambda));
check('rows in place of columns', isequal(pendusim(L', m', S, phi0', phid0', t'), phi));
fine = linspace(0, 5, 50001);
check('many instants', abs(pendusim(L, m, S, phi0, phid0, fine)(:, 1:100:end) - phi) < 1e-8);
one = pendusim(1, 1, 1, 0.1, 0, [0 0.5 1], 'pendulum', struct('gravity', 1.62));
check('one arm, on the moon', isequal(size(one), [1 3]) && abs(one(2) - (0.1 - 1.62 * cos(0.1) / 8)) < 2e-2);

% jobs
id = pendusim(L, m, S, phi0, phid0, t, 'job', 'of-octave');
check('a key leads to the same job', strcmp(id, pendusim(L, m, S, phi0, phid0, t, 'job', 'of-octave')));
check('the answer of a job', isequal(pendusim(id), phi));
check('its state, and the list', strcmp(pendujob(id, 'status').status, 'successful') && any(strcmp({pendujob().id}, id)) && isstruct(pendujob()));
named = penduask('forces', struct('pendulum', struct('L', L, 'm', m, 'S', S)), 'job', true, 'title', 'löst % of it');
found = pendujob('?operation=forces&title=st%20%25%20OF');
check('a title finds its job alone', numel(found) == 1 && strcmp(found.id, named) && strcmp(found.title, 'löst % of it'));
long = pendusim(L, m, S, phi0, phid0, 0:.001:4000, 'job', true);
check('cancel', strcmp(pendujob(long, 'cancel').status, 'dismissed'));
try
    pendujob(long);
    check('a dismissed job has no answer', false);
catch problem
    check('a dismissed job has no answer', ! isempty(strfind(problem.message, 'dismissed')));
end

% other routes, refusals, trouble
pendulum = struct('L', L, 'm', m, 'S', S);
server = getenv('PENDULUM_URL');
setenv('PENDULUM_URL', 'http://127.0.0.1:1');
check('a job of another server', isequal(pendusim(id, 'url', server), phi));
check('a list of another server', numel(pendujob('?limit=1', 'url', server)) > 1);
setenv('PENDULUM_URL', server);
orbits = penduask('orbits', struct('pendulum', pendulum, 'mode', 1, 'amplitude', 0.5));
check('what only JSON carries', ! isempty(orbits.message) && isfield(orbits, 'bifurcations'));
flips = penduask('ensembles', struct('pendulum', pendulum, 'states', {{struct('theta', [0; 0; 0; 0]), struct('theta', [3; 3; 3; 3])}}, 'duration', 2, 'observables', {{'first_flip'}}));
check('never is NaN', isnan(flips.first_flip.time(1)) && flips.first_flip.arm(1) == 0);
refused('a name without a value', 'pairs of a name and a value', L, m, S, phi0, phid0, t, 'method');
refused('no instants', 't, the instants', L, m, S, phi0, phid0);
modes = penduask('modes', struct('pendulum', pendulum, 'include', {{'A'}}));
check('matrices', abs(sort(sqrt(eig(modes.A))) - modes.omega) < 1e-9);
tree = penduask('trees', struct('pendulum', struct('length', [1; 1], 'mass', [1; 1], 'parent', [0; 1], 'damping', [0.1; 0.2])));
check('fields of real pendulums', tree.arms(2).damping == 0.2);
check('a path', numel(penduask('/v1/presets').presets) > 3);
refused('a field that nobody knows', '/fruit is not a known field', L, m, S, phi0, phid0, t, 'fruit', 3);
refused('a field of the pendulum that nobody knows', '/pendulum/fruit', L, m, S, phi0, phid0, t, 'pendulum', struct('fruit', 3));
S2 = [1 0; 1 1];
real = {[1; 1], [1; 1], S2, [0; 0], [0; 0], 0:.1:1, 'pendulum', struct('damping', [0.1; 0.2])};
try % of a server that takes no damping yet, the refusal of damping
    damped = pendusim(real{:});
    check('a real pendulum', abs(damped - pendusim(real{1:6}))(:, end) > 1e-3);
catch problem
    check('a real pendulum', ! isempty(strfind(problem.message, 'friction')) && isempty(strfind(problem.message, 'length')));
end
refused('an S that is none', 'row 2 of S', [1; 1], [1; 1], [1 0; 0 2], [0; 0], [0; 0], 0:.1:1, 'pendulum', struct('damping', [0.1; 0.2]));
refused('lengths that do not fit', 'as many', L, m, S, [0; 0], phid0, t);
refused('numbers that are none', 'finite', L, m, S, phi0, phid0, [0 NaN]);
% at once: who waits for it here waits for days
refused('no server', 'no server at http://127.0.0.1:1 (', L, m, S, phi0, phid0, t, 'url', 'http://127.0.0.1:1', 'patience', 1e6);
refused('another server', 'answers with a web page', L, m, S, phi0, phid0, t, 'url', arguments{6});
before = tic();
check('refusals for the moment are repeated', isequal(pendusim(L, m, S, phi0, phid0, t, 'url', arguments{3}), phi));
check('Retry-After is waited for', toc(before) >= 1);
check('a download goes on', isequal(pendujob(id, 'url', arguments{4}).phi.', phi));
answer = penduask('trajectories', struct('pendulum', pendulum, 'times', struct('start', 0, 'stop', 5, 'step', 0.01)));
out = fopen(arguments{5}, 'w');
fwrite(out, [answer.t answer.phi answer.phid answer.lambda].', 'double', 'ieee-le');
fclose(out);
