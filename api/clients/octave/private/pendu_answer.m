function answer = pendu_answer(method, path, body, options, fields)
% One request by curl, which every system has: returns a struct from a MAT-file or from JSON; a refusal is an error.
%
% fields   further header lines
%
% Temporary refusals are retried after their Retry-After, and a download that breaks off is resumed; if no server ever answered,
% this is an error at once. Only the name of a temporary file goes through a shell; the token is in that file, which only
% the user can read, and not in the list of processes.
persistent met % servers that have answered
where = 'set its address by PENDULUM_URL or the option url';
base = tempname();
files = struct('config', [base '.curl'], 'body', [base '.json'], 'data', [base '.mat'], 'head', [base '.head']);
tidy = onCleanup(@() cellfun(@remove, struct2cell(files)));
write(files.body, body);
begin = tic();
have = 0;
wait = 0.1;
while true
    [kind, code, failed, said] = curl(method, path, body, options, fields, files, have);
    page = strncmpi(kind, 'text/html', 9);
    if code == 0 && failed && ~any(strcmp(met, options.url))
        error('pendusim:server', 'no server at %s (%s): %s', options.url, said, where);
    end
    met = unique([met {options.url}]);
    rest = 0;
    if any(code == [429 502 503 504])
        said = refusal(code, text_of(files.data));
        rest = after(text_of(files.head));
        % the refusal is in the file of a partial download
        have = 0;
    elseif page
        error('pendusim:server', '%d: %s answers with a web page, so it is not pendulumd: %s', code, options.url, where);
    elseif code >= 400
        said = refusal(code, text_of(files.data));
        if code == 401 && isempty(options.token)
            said = [said char(10) 'Set PENDULUM_TOKEN (openssl rand -hex 16) before you submit jobs, or give the option token.'];
        end
        error('pendusim:refused', '%s', said);
    elseif ~failed
        answer = read(kind, files.data);
        return
    else
        % the connection broke; the received part of results is kept, with their ETag
        before = have;
        have = bytes_of(files.data);
        etag = regexp(text_of(files.head), '(?i)etag: *("[^"]*")', 'tokens');
        if ~strcmp(method, 'GET') || isempty(etag) || failed == 33 % the range does not fit this answer
            have = 0;
        elseif have > before
            begin = tic();
            wait = 0.1;
            fields = [fields(~strncmp(fields, 'If-Range', 8)) {['If-Range: ' etag{end}{1}]}];
        end
    end
    if toc(begin) + max(wait, rest) > options.patience
        error('pendusim:server', '%s%s: %s', options.url, path, said);
    end
    pause(max(wait, rest));
    wait = min(2 * wait, 5);
end
end

function [kind, code, failed, said] = curl(method, path, body, options, fields, files, have)
% kind: media type; code: HTTP status, 0 without an answer; failed: whether it is incomplete; said: why
fields = [fields {'Content-Type: application/json', 'Expect:'}];
% answers with many rows, which MAT contains completely; others have parts that only JSON has
if any(strcmp(path, {'/v1/trajectories', '/v1/ensembles', '/v1/lyapunov', '/v1/sections'})) || ~isempty(regexp(path, '/results$', 'once'))
    fields{end + 1} = 'Accept: application/x-matlab-data, application/json;q=0.5';
end
if ~isempty(options.token)
    fields{end + 1} = ['Authorization: Bearer ' options.token];
end
lines = [{'silent', 'show-error', 'globoff', 'connect-timeout = 10', set('url', [options.url path]), set('request', method), ...
          set('output', files.data), set('dump-header', files.head), 'write-out = "\n%{http_code} %{content_type}\n"'}, ...
         cellfun(@(field) set('header', field), fields, 'UniformOutput', false)];
if ~isempty(body)
    lines{end + 1} = set('data-binary', ['@' files.body]);
end
if have > 0
    lines{end + 1} = sprintf('continue-at = %d', have);
else
    remove(files.data);
end
write(files.config, sprintf('%s\n', lines{:}));
clean = '';
if isunix()
    clean = 'LD_LIBRARY_PATH= '; % MATLAB's own libraries are not curl's
end
[failed, said] = system(sprintf('%scurl -K "%s" 2>&1', clean, files.config));
words = regexp(said, '(\d+) ([^\n]*)\n$', 'tokens', 'once');
said = strtrim(regexprep(said, '\n?\d+ [^\n]*\n$', ''));
kind = '';
code = 0;
if ~isempty(words)
    code = str2double(words{1});
    kind = words{2};
end
end

function seconds = after(head)
% the seconds of a Retry-After; 0 if there is none, or if it is a date
words = regexp(head, '(?i)retry-after: *(\d+)', 'tokens');
seconds = 0;
if ~isempty(words)
    seconds = str2double(words{end}{1});
end
end

function answer = read(kind, file)
if strncmp(kind, 'application/x-matlab-data', 25)
    answer = load(file, '-mat');
else
    answer = jsondecode(text_of(file));
end
if isfield(answer, 'warnings')
    answer.warnings = cellstr(answer.warnings);
    shown = warning('off', 'backtrace'); % the lines of these functions do not help
    warning('pendusim:accuracy', '%s', strjoin(answer.warnings(:).', char(10)));
    warning(shown);
end
end

function text = refusal(code, text)
% the text of a problem, one line per fault
try
    problem = jsondecode(text);
    text = sprintf('%d %s', code, problem.detail);
    if isfield(problem, 'errors')
        for k = 1:numel(problem.errors)
            text = sprintf('%s\n  %s %s', text, problem.errors(k).pointer, problem.errors(k).detail);
        end
    end
catch
    text = sprintf('%d %s', code, text);
end
end

function line = set(name, value)
line = sprintf('%s = "%s"', name, strrep(strrep(value, '\', '\\'), '"', '\"'));
end

function text = text_of(file)
text = '';
handle = fopen(file, 'r');
if handle >= 0
    text = fread(handle, [1 Inf], 'uint8=>char');
    fclose(handle);
end
end

function count = bytes_of(file)
found = dir(file);
count = 0;
if ~isempty(found)
    count = found.bytes;
end
end

function write(file, text)
handle = fopen(file, 'w');
if handle < 0
    error('pendusim:file', 'the file %s cannot be written', file);
end
if isunix()
    system(sprintf('chmod 600 "%s"', file));
end
fwrite(handle, text);
fclose(handle);
end

function remove(file)
if exist(file, 'file')
    delete(file);
end
end
