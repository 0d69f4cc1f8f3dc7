function answer = pendu_answer(method, path, body, options, fields)
% One exchange by curl, which MATLAB and Octave have on every system: a struct of a MAT-file or of JSON; a refusal is an error.
%
% fields   further header lines
%
% curl itself repeats a refusal for the moment after its Retry-After. A download that breaks off goes on where it was. Nothing
% goes through a shell but the name of a temporary file; the token stands in that file, which is ours alone, and not in the list of processes.
base = tempname();
files = struct('config', [base '.curl'], 'body', [base '.json'], 'data', [base '.mat'], 'head', [base '.head']);
tidy = onCleanup(@() cellfun(@remove, struct2cell(files)));
write(files.body, body);
last = 'nothing arrives';
begin = tic();
have = 0;
while toc(begin) < options.patience || have == 0
    [kind, status, said] = curl(method, path, body, options, fields, files, have);
    if status == 0
        answer = read(kind, files.data);
        return
    end
    last = strtrim(said);
    % 18: a part only, 56: the line broke; what is there already stays, of results by their ETag
    before = have;
    have = bytes_of(files.data);
    etag = regexp(text_of(files.head), '(?i)etag: *("[^"]*")', 'tokens');
    if ~any(status == [18 56]) || ~strcmp(method, 'GET') || isempty(etag) || have == 0
        break
    end
    if have > before
        begin = tic();
    end
    fields = [fields(~strncmp(fields, 'If-Range', 8)) {['If-Range: ' etag{end}{1}]}];
    pause(0.1);
end
error('pendusim:server', '%s%s: %s', options.url, path, last);
end

function [kind, status, said] = curl(method, path, body, options, fields, files, have)
% kind: status and media type; status: curl's own, 0 once the answer is whole
fields = [fields {'Content-Type: application/json', 'Expect:'}];
if isempty(strfind(body, '"include"')) && ~any(strcmp(method, 'DELETE'))
    fields{end + 1} = 'Accept: application/x-matlab-data, application/json;q=0.5';
end
if ~isempty(options.token)
    fields{end + 1} = ['Authorization: Bearer ' options.token];
end
lines = [{'silent', 'show-error', 'globoff', set('url', [options.url path]), set('request', method), set('output', files.data), ...
          set('dump-header', files.head), 'retry = 100', 'retry-connrefused', sprintf('retry-max-time = %g', options.patience), ...
          'write-out = "\n%{http_code} %{content_type}\n"'}, cellfun(@(field) set('header', field), fields, 'UniformOutput', false)];
if ~isempty(body)
    lines{end + 1} = set('data-binary', ['@' files.body]);
end
if have > 0
    lines{end + 1} = sprintf('continue-at = %d', have);
end
write(files.config, sprintf('%s\n', lines{:}));
clean = '';
if isunix()
    clean = 'LD_LIBRARY_PATH= '; % MATLAB's own libraries are not curl's
end
[status, said] = system(sprintf('%scurl -K "%s" 2>&1', clean, files.config));
words = regexp(said, '(\d+) ([^\n]*)\n$', 'tokens', 'once');
if status ~= 0 || isempty(words)
    kind = '';
    status = max(status, 1);
    return
end
kind = words{2};
if str2double(words{1}) >= 400
    error('pendusim:refused', '%s', refusal(words{1}, text_of(files.data)));
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
    warning('pendusim:accuracy', '%s', strjoin(answer.warnings(:).', char(10)));
end
end

function text = refusal(code, text)
% the sentences of a problem, each fault in a line
try
    problem = jsondecode(text);
    text = sprintf('%s %s', code, problem.detail);
    if isfield(problem, 'errors')
        for k = 1:numel(problem.errors)
            text = sprintf('%s\n  %s %s', text, problem.errors(k).pointer, problem.errors(k).detail);
        end
    end
catch
    text = sprintf('%s %s', code, text);
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
