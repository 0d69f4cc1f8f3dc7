function text = pendu_json(value)
% JSON of a value. Unlike jsonencode it writes every digit of a double, and a cell of one number as an array.
if isa(value, 'string') && isscalar(value)
    value = char(value);
end
if ischar(value)
    text = ['"' regexprep(strrep(strrep(value, '\', '\\'), '"', '\"'), '[\x00-\x1f]', ' ') '"'];
elseif isstruct(value) && isscalar(value)
    names = fieldnames(value).';
    parts = cellfun(@(name) ['"' name '":' pendu_json(value.(name))], names, 'UniformOutput', false);
    text = ['{' strjoin(parts, ',') '}'];
elseif iscell(value) || isstruct(value) || isa(value, 'string')
    if ~iscell(value)
        value = num2cell(value);
    end
    if ~isempty(value) && all(cellfun(@(item) isnumeric(item) && isscalar(item), value(:)))
        text = numbers(cellfun(@double, value(:).'));
    else
        text = ['[' strjoin(cellfun(@pendu_json, value(:).', 'UniformOutput', false), ',') ']'];
    end
elseif islogical(value) && isscalar(value)
    words = {'false', 'true'};
    text = words{value + 1};
elseif isnumeric(value) || islogical(value)
    value = double(value);
    if isvector(value) || isempty(value)
        text = numbers(value(:).');
        if isscalar(value)
            text = text(2:end - 1);
        end
    else
        rows = arrayfun(@(k) numbers(value(k, :)), 1:size(value, 1), 'UniformOutput', false);
        text = ['[' strjoin(rows, ',') ']'];
    end
else
    error('pendusim:json', 'a %s cannot be sent', class(value));
end
end

function text = numbers(row)
if ~all(isfinite(row)) || ~isreal(row)
    error('pendusim:json', 'numbers have to be real and finite');
end
text = sprintf('%.17g,', row);
text = ['[' text(1:end - 1) ']'];
end
