function options = pendu_options(pairs)
% The options of all functions, with their defaults.
options = struct('url', getenv('PENDULUM_URL'), 'token', getenv('PENDULUM_TOKEN'), 'patience', 60, 'job', false, 'title', '', 'progress', false);
if mod(numel(pairs), 2) || ~all(cellfun(@ischar, pairs(1:2:end)))
    error('pendusim:option', 'options are pairs of a name and a value, as ''url'', ''http://127.0.0.1:8080''');
end
for k = 1:2:numel(pairs)
    if ~isfield(options, pairs{k})
        error('pendusim:option', 'there is no option %s, only: %s', pairs{k}, strjoin(fieldnames(options).', ', '));
    end
    options.(pairs{k}) = pairs{k + 1};
end
if isempty(options.url)
    options.url = 'http://127.0.0.1:8080';
end
options.url = regexprep(options.url, '/+$', '');
end
