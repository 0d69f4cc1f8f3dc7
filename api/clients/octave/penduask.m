function [answer, job] = penduask(route, request, varargin)
% PENDUASK  Sends a request to any route of a pendulumd server.
%
%   answer = penduask('modes', struct('pendulum', pendulum))
%   answer = penduask('ensembles', request, 'url', 'http://127.0.0.1:8080')
%   id = penduask('ensembles', request, 'job', true)      computed in the background; see PENDUJOB
%   answer = penduask('/v1/presets')                      a path, by GET
%
%   request  a struct: numbers, texts, structs, and matrices (an array of rows). A list of one number is a cell: {2}.
%   answer   a struct of the arrays; rows are instants or members, columns are arms; answer.stats, answer.warnings
%
%   Options: 'url' (PENDULUM_URL), 'token' (PENDULUM_TOKEN), 'patience' (60: s for which temporary refusals are retried), 'job' (true,
%   or a key of your own: the same key returns the same job), 'title' (the job's name), 'progress'.
options = pendu_options(varargin);
if route(1) == '/'
    answer = pendu_answer('GET', route, '', options, {});
elseif isequal(options.job, false)
    answer = pendu_answer('POST', ['/v1/' route], pendu_json(request), options, {});
else
    key = options.job;
    if ~ischar(key)
        [~, key] = fileparts(tempname());
        key = sprintf('%s-%.9f-%.15f', key, now(), rand());
    end
    fields = {'Prefer: respond-async', ['Idempotency-Key: ' key]};
    if ~isempty(options.title)
        fields{end + 1} = ['Job-Title: ' sprintf('%%%02X', unicode2native(options.title, 'UTF-8'))];
    end
    job = pendu_answer('POST', ['/v1/' route], pendu_json(request), options, fields);
    if ~isfield(job, 'id')
        error('pendusim:jobs', 'this server stores no jobs');
    end
    answer = job.id;
end
end
