"""Holds every reply that the wire tests saw against the OpenAPI document, and shows first that wrong replies are noticed.

    replies.py build/release/tests/wire/replies.ndjson

Each line of the file is a reply that some test saw: {"method", "path", "status", "content_type", "body"}, the body as text
(or null where there was none). A reply passes when the document has its path, method, status and media type, and its body
is valid under the schema, without a field that the document does not know. Prints each fault, what no reply reached (a
fault too), and last "N passed, N failed". To be reached are every success and every 422 of every
operation, and every other error of the document once.
"""
import copy
import csv
import io
import json
import pathlib
import re
import sys
import warnings
from urllib.parse import urlsplit

warnings.simplefilter("ignore", DeprecationWarning)  # jsonschema 4.18 and later have another resolver, 4.10 has not
import jsonschema  # noqa: E402

sys.dont_write_bytecode = True
TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "api/call"))
from openapi_embed import load, named  # noqa: E402, F401

METHODS = ("get", "post", "put", "delete", "patch")
LONG = 40  # items of an array that are validated when all of them look alike
NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?(e-?[0-9]+)?")
MAY_LACK = re.compile(r"((first_flip|lambda_max|lambda_min)_time|flip_time|sign_change)(_[0-9]+)?")  # times that never come


class Fault(Exception):
    pass


def close(schema):
    """Forbids, everywhere in a schema, fields that it does not name."""
    if isinstance(schema, list):
        for item in schema:
            close(item)
    if isinstance(schema, dict):
        if isinstance(schema.get("properties"), dict) and "additionalProperties" not in schema:
            schema["additionalProperties"] = False
        for value in schema.values():
            close(value)


def parse(text):
    """JSON as RFC 8259 has it: no NaN, no key twice."""

    def constant(name):
        raise Fault(f"the body has {name}, which is no JSON")

    def pairs(items):
        value = dict(items)
        if len(value) != len(items):
            raise Fault(f"the body has a key twice among {[key for key, _ in items]}")
        return value

    try:
        return json.loads(text, parse_constant=constant, object_pairs_hook=pairs)
    except ValueError as error:
        raise Fault(f"the body is not JSON: {error}") from error


def shape(value):
    if isinstance(value, list):
        return ["list", len(value), shape(value[0]) if value else None]
    return "number" if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def shorten(value):
    """Cuts long arrays whose items are all numbers, or all rows of numbers of one length."""
    if isinstance(value, dict):
        return {key: shorten(item) for key, item in value.items()}
    if not isinstance(value, list):
        return value
    if len(value) > LONG and shape(value[0]) and all(shape(item) == shape(value[0]) for item in value):
        value = value[:LONG]
    return [shorten(item) for item in value]


def check_csv(text):
    lines = text.split("\n")
    if lines.pop() or len(lines) < 2:
        raise Fault("the CSV has no header and line, or its last line does not end")
    names = lines[0].split(",")
    width = len(names)
    while lines[-1].startswith("# "):
        lines.pop()  # words about the numbers above: nothing but such lines may follow them
    for number, line in enumerate(lines[1:], 2):
        fields = line.split(",")
        if len(fields) != width or not all(NUMBER.fullmatch(field) or (not field and MAY_LACK.fullmatch(name))
                                           for field, name in zip(fields, names)):
            raise Fault(f"line {number} of the CSV is not {width} numbers: {line[:100]!r}")


def check_table(text, query):
    """The answers of a class, as RFC 4180 has them; for a spreadsheet with its mark, and with its cells parted at semicolons."""
    if text.startswith("\ufeff") != bool(query):
        raise Fault(f"the mark of UTF-8 is not where a spreadsheet was asked for: {text[:10]!r}")
    delimiter = ";" if query == "decimal=comma" else ","
    rows = list(csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline=""), delimiter=delimiter, strict=True))
    if rows[0] != ["item", "id", "step", "pupil", "nickname", "value", "changed"]:
        raise Fault(f"the table begins with {rows[0]}")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]) or row[4][:1] in ("=", "+", "-", "@") and row[4]:
            raise Fault(f"row {number} of the table is {row}")


def check_ndjson(text):
    lines = text.split("\n")
    if lines.pop() or not lines:
        raise Fault("the NDJSON has no line, or its last line does not end")
    rows = [parse(line) for line in lines]
    if len(rows) > 1 and isinstance(rows[-1], dict) and "stats" in rows[-1]:
        last = rows.pop()  # what holds of the rows above
        if not isinstance(last["stats"], dict) or last.keys() - {"stats", "warnings"}:
            raise Fault(f"the last line of the NDJSON is no statistics: {lines[-1][:100]!r}")
    for number, row in enumerate(rows, 1):
        if not isinstance(row, dict) or list(row) != list(rows[0]):
            raise Fault(f"line {number} of the NDJSON is no object with the members of the first: {lines[number - 1][:100]!r}")


BINARY = ("application/octet-stream", "application/x-npz", "application/vnd.apache.parquet", "application/x-hdf5",
          "application/x-matlab-data", "application/zip")
PAGE = ("text/html", "text/css", "text/javascript", "image/svg+xml", "font/woff2")  # for browsers, whose tests look at it


SAMPLE = re.compile(r'[a-zA-Z_:][a-zA-Z0-9_:]*(\{[a-zA-Z_]\w*="[^"\\]*"(,[a-zA-Z_]\w*="[^"\\]*")*\})? [-+0-9.eInf]+')


def check_metrics(text):
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith(("# HELP ", "# TYPE ")) and not SAMPLE.fullmatch(line):
            raise Fault(f"line {number} is no sample of Prometheus' text format: {line[:100]!r}")


EVENT = {"Job": re.compile(r"event: progress\nid: [a-z]+-[0-9]+\ndata: (.*)"),
         "ClassItem": re.compile(r"event: item\nid: [0-9]+\ndata:(.*)")}
END = "event: end\ndata: {}"  # the last event of a room


def read_events(text, kind):
    """The data of the events of a stream that has ended, of jobs or of items of a class."""
    pieces = text.split("\n\n")
    if pieces.pop() or not pieces or pieces[0] != "retry: 2000":
        raise Fault(f"the stream begins or ends otherwise: {text[:100]!r}")
    if kind == "ClassItem" and pieces[-1] == END:
        pieces.pop()
    events = [EVENT[kind].fullmatch(piece) for piece in pieces[1:] if piece != ":"]
    if (kind == "Job" and not events) or not all(events):
        raise Fault(f"the stream has something else than events: {text[:300]!r}")
    return [parse(event.group(1)) for event in events]


class Document:
    def __init__(self, path):
        self.document = load(path)
        self.strict = copy.deepcopy(self.document)
        close(self.strict["components"]["schemas"])
        close(self.strict["paths"])
        self.resolver = jsonschema.RefResolver("", self.strict)
        # a {file} is a path of its own, slashes and all; a {room} follows its pattern, for it stands where any word may
        room = next(p["schema"]["pattern"] for p in self.strict["paths"]["/{room}"]["get"]["parameters"] if p["name"] == "room")
        self.paths = [(re.compile(re.sub(r"\\\{[^/]*?\\\}", "[^/]+", re.escape(path).replace(r"\{file\}", ".+")
                                         .replace(r"\{room\}", room.strip("^$"))) + "$"), path, item)
                      for path, item in self.strict["paths"].items()]
        self.wanted = {self.goal(method, path, status)
                       for path, item in self.document["paths"].items() for method in METHODS if method in item
                       for status in item[method]["responses"] if status != "default"}

    @staticmethod
    def goal(method, path, status):
        """What a reply reaches: errors that do not depend on the operation are reached together."""
        return (method.upper(), path, status) if status in ("200", "422") else ("error", status)

    def resolve(self, thing):
        return self.resolver.resolve(thing["$ref"])[1] if "$ref" in thing else thing

    def problem(self):
        return self.strict["components"]["responses"]["Other"]

    def find(self, method, path, status):
        """The response of the document that a reply should follow, and what was reached by it."""
        for pattern, template, item in self.paths:
            if not pattern.match(path):
                continue
            if method == "options":
                return None, None
            operation = item.get({"head": "get", "query": "post"}.get(method, method))
            if not operation:
                return self.expect(status, (405, 400), method, path), None
            responses = operation["responses"]
            reached = self.goal(method, template, str(status))
            return self.resolve(responses.get(str(status)) or responses["default"]), reached
        return self.expect(status, (404, 204) if method == "options" else (404,), method, path), None

    def expect(self, status, statuses, method, path):
        if status not in statuses and status not in (400, 408, 413, 414, 417, 431, 500, 501, 503, 505):
            raise Fault(f"{method.upper()} {path} is not in the document and was answered {status}")
        return self.problem()

    def validate(self, schema, value):
        validator = jsonschema.Draft202012Validator(schema, resolver=self.resolver)
        fault = jsonschema.exceptions.best_match(validator.iter_errors(shorten(value)))
        if fault:
            raise Fault(f"at /{'/'.join(map(str, fault.absolute_path))}: {fault.message[:300]}")

    def check(self, reply):
        """Checks one reply and answers what it reached."""
        method, status = reply["method"].lower(), reply["status"]
        response, reached = self.find(method, urlsplit(reply["path"]).path, status)
        if method in ("head", "options") and status < 400 or response is None or "content" not in response:
            if reply.get("body"):
                raise Fault(f"{reply['method']} has a body")
            return reached
        media_type = (reply.get("content_type") or "").split(";")[0].strip().lower()
        if status >= 400 and media_type != "application/problem+json":
            raise Fault(f"an error of media type {media_type!r}")
        if media_type not in response["content"]:
            raise Fault(f"the media type {media_type!r} is none of {', '.join(response['content'])}")
        if method == "head" or status == 206:  # a piece of what is looked at as a whole
            return reached
        if media_type == "text/event-stream":
            kind = "ClassItem" if reply["path"].startswith("/v1/classes/") else "Job"
            for event in read_events(reply["body"], kind):
                self.validate({"$ref": f"#/components/schemas/{kind}"}, event)
            return reached
        if media_type == "text/plain":
            check_metrics(reply["body"])
            return reached
        if media_type == "text/csv":
            path, _, query = reply["path"].partition("?")
            if path.endswith("/table"):
                check_table(reply["body"], query)
            else:
                check_csv(reply["body"])
            return reached
        if media_type == "application/x-ndjson":
            check_ndjson(reply["body"])
            return reached
        if media_type in BINARY or media_type in PAGE or media_type.startswith("image/"):
            return reached
        body = parse(reply["body"])
        self.validate(response["content"][media_type]["schema"], body)
        if status >= 400 and body["status"] != status:
            raise Fault(f"the problem says status {body['status']}")
        return reached


def held(document, file):
    """How many replies of a file are as the document says, and what is wrong with the others."""
    passed, wrong = 0, []
    # the beginning of a picture or an archive is a string like any other, but no UTF-8
    for number, line in enumerate(open(file, encoding="utf-8", errors="replace"), 1):
        try:
            reply = json.loads(line)
            document.wanted.discard(document.check(reply))
            passed += 1
        except (Fault, ValueError, KeyError, TypeError) as fault:
            wrong.append(f"{file}:{number}: {fault!r}" if not isinstance(fault, Fault) else
                         f"{file}:{number}: {reply['method']} {reply['path']} {reply['status']}: {fault}")
    return passed, wrong


def main(file):
    path, bad = TOP / "api/call/openapi.yaml", TOP / "tests/rules/replies_bad.ndjson"
    missed, _ = held(Document(path), bad)
    document = Document(path)
    passed, wrong = held(document, file)
    wrong += [f"never reached: {' '.join(map(str, goal))}" for goal in sorted(document.wanted)]
    if missed:
        wrong.append(f"FAIL {missed} wrong replies of {bad.name} are not noticed")
    print(*wrong, sep="\n", end="\n" if wrong else "")
    print(f"{passed} passed, {len(wrong)} failed")
    return len(wrong) > 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
