function answer = pendujob(id, what, varargin)
% PENDUJOB  The jobs of a pendulumd server, which it computes in the background.
%
%   answer = pendujob(id)             waits for the end and returns the answer (PENDUASK); 'progress', false shows nothing
%   state = pendujob(id, 'status')    its state: state.status, state.progress (percent), state.message
%   state = pendujob(id, 'cancel')    cancels it
%   jobs = pendujob()                 your jobs, the newest first, an array of structs; needs a token
%   jobs = pendujob('?status=running&title=flips')   the jobs that match, with the parameters of GET /v1/jobs
%
%   Options of PENDUASK may follow: pendujob(id, 'result', 'url', url), pendujob('?status=running', 'url', url). A download that breaks off is resumed.
if nargin == 0
    id = '?limit=100';
end
if nargin < 2
    what = 'result';
elseif ~any(strcmp(what, {'result', 'status', 'cancel'}))
    varargin = [{what} varargin];
    what = 'result';
end
if id(1) == '?'
    answer = listed(['/v1/jobs' id], pendu_options(varargin));
    return
end
options = pendu_options(varargin);
path = ['/v1/jobs/' id];
if strcmp(what, 'cancel')
    answer = pendu_answer('DELETE', path, '', options, {});
    return
end
answer = pendu_answer('GET', path, '', options, {});
pause_seconds = 0.02;
while strcmp(what, 'result') && any(strcmp(answer.status, {'accepted', 'running'}))
    if options.progress
        fprintf('\r%3d %% %s ', answer.progress, answer.status);
    end
    pause(pause_seconds);
    pause_seconds = min(1.5 * pause_seconds, 1);
    answer = pendu_answer('GET', path, '', options, {});
end
if strcmp(what, 'status')
    return
end
if options.progress
    fprintf('\r%3d %% %s\n', answer.progress, answer.status);
end
if ~strcmp(answer.status, 'successful')
    error('pendusim:job', 'the job %s is %s: %s', id, answer.status, answer.message);
end
answer = pendu_answer('GET', [path '/results'], '', options, {});
end

function list = listed(path, options)
% all jobs of a list, which has pages
found = {};
while ~isempty(path)
    page = pendu_answer('GET', path, '', options, {});
    jobs = page.jobs;
    if isstruct(jobs)
        jobs = num2cell(jobs);
    end
    found = [found; jobs(:)];
    path = '';
    links = page.links;
    if isstruct(links)
        links = num2cell(links);
    end
    for k = 1:numel(links)
        if strcmp(links{k}.rel, 'next')
            path = links{k}.href;
        end
    end
end
list = alike(found);
end

function list = alike(list)
% an array of structs from jobs, with empty values for the fields that a job lacks
if ~iscell(list)
    return
end
fields = cellfun(@fieldnames, list(:), 'UniformOutput', false);
names = unique(vertcat(fields{:})).';
for k = 1:numel(list)
    for name = names(~isfield(list{k}, names))
        list{k}.(name{1}) = [];
    end
    list{k} = orderfields(list{k});
end
list = vertcat(list{:});
end
