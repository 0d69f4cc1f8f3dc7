"""Posts every example of the OpenAPI document to a live server.

    examples.py BUILD

Each request example must be answered with success and a valid body; where the operation's answer has an example of the same name
it must be that answer: the same fields, the same texts and whole numbers, other numbers to 1e-5 of the largest in their
array. What a computation takes (stats) is compared by its fields alone. Each form of an answer must have everything that its JSON has, or
be refused in favour of JSON, which a client gets that accepts both. Then every preset is fetched, and its parts are
posted as a trajectory; and the document of each tag, and of two, must have the operations of these tags, all components that they
refer to, and no others. Prints "N passed, N failed".
"""
import io
import json
import re
import sys
import tempfile
import urllib.error
import urllib.request

from replies import BINARY, Document, Fault, named
from rule import TOP, optional
from servers import daemon


def ask(url, method, body, accept):
    data = None if body is None else json.dumps(body).encode()
    headers = {"Accept": accept} | ({"Content-Type": "application/json"} if data else {})
    request = urllib.request.Request(url, data, headers, method=method.upper())
    try:
        with urllib.request.urlopen(request, timeout=300) as answer:
            return answer.status, answer.headers["Content-Type"], answer.read().decode(errors="surrogateescape")
    except urllib.error.HTTPError as error:
        return error.code, error.headers["Content-Type"], error.read().decode()


def numbers(value):
    """All numbers of nested arrays, or None where there is something else."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return [value]
    if not isinstance(value, list):
        return None
    parts = [numbers(item) for item in value]
    return None if None in parts else [number for part in parts for number in part]


def same(at, got, want):
    if type(got) is not type(want) and not (numbers(got) and numbers(want)):
        raise Fault(f"{at} is {got!r}, the example has {want!r}")
    if isinstance(want, dict):
        if got.keys() != want.keys():
            raise Fault(f"{at} has the fields {list(got)}, the example {list(want)}")
        for key in want:
            if at + "/" + key != "/stats":
                same(at + "/" + key, got[key], want[key])
            elif got[key].keys() != want[key].keys():
                raise Fault(f"/stats has the fields {list(got[key])}, the example {list(want[key])}")
    elif numbers(want) is not None:
        a, b = numbers(got), numbers(want)
        scale = max(map(abs, b), default=0)
        if len(a) != len(b) or any(abs(x - y) > 1e-5 * max(scale, 1e-9) for x, y in zip(a, b)):
            raise Fault(f"{at} is {got}, the example has {want}")
    elif isinstance(want, list):
        if len(got) != len(want):
            raise Fault(f"{at} has {len(got)} items, the example {len(want)}")
        for i, item in enumerate(want):
            same(f"{at}/{i}", got[i], item)
    elif got != want:
        raise Fault(f"{at} is {got!r}, the example has {want!r}")


def compare(media_type, got, want):
    if media_type == "application/json":
        same("", json.loads(got), want)
        return
    rows = [[[float(field) if field else None for field in line.split(",")] for line in text.split("\n")[1:-1]] for text in (got, want)]
    if got.split("\n")[0] != want.split("\n")[0]:
        raise Fault(f"the header is {got.split(chr(10))[0]!r}")
    same("CSV", *rows)


def good(operation):
    """The status of success, and its response; those by reference have no examples."""
    status = min(operation["responses"])
    response = operation["responses"][status]
    return int(status), response if "content" in response else {"content": {}}


def cases(document):
    """(method, path, name, request body, media type, answer or None, status) of every example."""
    for path, item in document.document["paths"].items():
        if path.startswith(("/v1/jobs", "/v1/classes/", "/page/", "/oembed")):
            continue  # no id, code or host is known beforehand, nor the page's digest: tests/wire asks for them
        shared = item.get("parameters", [])
        for method, operation in item.items():
            if method == "parameters" or method == "delete" or operation.get("security") == [{"bearer": []}]:
                continue  # what an example deletes, or lists by a token, is its maker's own: tests/wire does so
            requests = operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("examples", {})
            bodies = {name: example["value"] for name, example in requests.items()}
            for parameter in shared + operation.get("parameters", []):
                if "$ref" in parameter or parameter["in"] != "path":
                    continue  # a header field or a query that may be left out
                bodies[parameter["example"]] = None
                path = path.replace("{" + parameter["name"] + "}", parameter["example"])
            for media_type, content in good(operation)[1]["content"].items():
                if media_type.startswith("image/") or media_type in BINARY:
                    continue  # not every example can be drawn; readback.sh reads what is no text
                answers = {name: example["value"] for name, example in content.get("examples", {}).items()}
                for name in answers.keys() - bodies.keys():
                    raise Fault(f"{path}: the answer {name} has no request")
                for name, body in (bodies or {"": None}).items():
                    if media_type != "application/json" and {"include", "poles", "branch"} & set(body or {}):
                        continue  # matrices, poles and a whole branch are answered in JSON only
                    yield method, path, name, body, media_type, answers.get(name), good(operation)[0]


def check(document, base, method, path, body, media_type, wanted=200):
    """Asks, holds the answer against the document, and returns it."""
    status, content_type, got = ask(base + path, method, body, media_type)
    if status != wanted:
        raise Fault(f"answered {status}: {got}")
    document.check({"method": method, "path": path, "status": status, "content_type": content_type, "body": got})
    return got


def example(document, base, method, path, name, body, media_type, want, status):
    got = check(document, base, method, path, body, media_type, status)
    if want is not None:
        compare(media_type, got, want)


def leaves(value, name=""):
    """The names of the parts of a JSON answer, as other forms have them: z_re, energy_total, stats_steps."""
    if not isinstance(value, dict):
        return {name}
    return {leaf for key, part in value.items() for leaf in leaves(part, f"{name}_{key}".removeprefix("_"))}


def parts(name, value):
    """The leaves of an array of NPZ or MAT: complex numbers and structs have several."""
    if value.dtype.names:
        return {leaf for part in value.dtype.names for leaf in parts(f"{name}_{part}", value[part].flat[0])}
    return {f"{name}_re", f"{name}_im"} if value.dtype.kind == "c" else {name}


def names_in(form, data, headers):
    """The leaves of an answer in a form; a form without a place for statistics has them all."""
    if form == "application/x-npz":
        return {leaf for name, value in optional("numpy").load(io.BytesIO(data)).items() for leaf in parts(name, value)}
    if form == "application/x-matlab-data":
        return {leaf for name, value in optional("scipy.io").io.loadmat(io.BytesIO(data)).items() if name[0] != "_" for leaf in parts(name, value)}
    if form == "application/x-hdf5":
        with optional("h5py").File(io.BytesIO(data)) as file:
            return {*file, "warnings", *(f"stats_{name}" for name in file.attrs)}
    if form == "application/vnd.apache.parquet":
        footer = data[-8 - int.from_bytes(data[-8:-4], "little"):]
        words = {word.decode().strip("_") for word in re.findall(rb"[a-z][a-z_]*", footer)}
        return words | {f"stats_{word}" for word in words} | {"warnings"}
    if form == "application/x-ndjson":
        return {leaf for line in data.splitlines() for leaf in leaves(json.loads(line))}
    columns = data.decode().split("\n")[0] if form == "text/csv" else re.sub(r"\[[0-9,]*\]", "", headers["X-Columns"])
    return {re.sub(r"(_\d+)+$", "", name) for name in columns.split(",")} | ({"warnings"} if form != "text/csv" or b"\n# warning" in data else set())


FORMS = {"text/csv": "json", "application/vnd.apache.parquet": "json", "application/octet-stream": "json", "application/x-ndjson": "json", "application/x-npz": "numpy",
         "application/x-matlab-data": "scipy.io", "application/x-hdf5": "h5py"}
# What stands in the statistics too, under these names.
TOLD = {"end": "stats_end", "message": "stats_end", "identity_sum_inverse_omega_squared": "stats_sum_inverse_omega_squared",
        "identity_length_total_over_g": "stats_length_total_over_g", "identity_relative_difference": "stats_relative_difference"}


def carried(_, base, path, name, body):
    whole = leaves(json.loads(ask(base + path, "post", body, "application/json")[2]))
    for form, library in FORMS.items():
        if not optional(library):
            continue
        request = urllib.request.Request(base + path, json.dumps(body).encode(), {"Content-Type": "application/json", "Accept": form})
        try:
            with urllib.request.urlopen(request, timeout=300) as answer:
                has = names_in(form, answer.read(), answer.headers)
        except urllib.error.HTTPError as error:
            if error.code != 422 or b"only in application/json" not in error.read() or ask(base + path, "post", body, f"{form}, application/json;q=0.5")[0] != 200:
                raise Fault(f"{form} is answered {error.code}, or JSON is no way out") from error
            continue
        lost = {leaf for leaf in whole if TOLD.get(leaf, leaf) not in has and not (TOLD.get(leaf, leaf).startswith("stats_") and form in ("text/csv", "application/octet-stream"))}
        if lost:
            raise Fault(f"{form} lacks {sorted(lost)}")


def preset(document, base, name):
    got = json.loads(check(document, base, "get", f"/v1/presets/{name}", None, "application/json"))
    body = {key: got[key] for key in ("pendulum", "initial", "times")}
    check(document, base, "post", "/v1/trajectories", body | {"rtol": 1e-6, "digits": 6}, "application/json")


def tagged(_, base, path, *tags):
    whole, got = (json.loads(ask(base + path + query, "get", None, "*/*")[2]) for query in ("", "?tag=" + ",".join(tags)))
    have = {route: item for route, item in whole["paths"].items() if any(isinstance(one, dict) and set(one["tags"]) & set(tags) for one in item.values())}
    if got["paths"] != have:
        raise Fault(f"it has the paths {list(got['paths'])}, not {list(have)}")
    if [tag["name"] for tag in got["tags"]] != [tag["name"] for tag in whole["tags"] if tag["name"] in tags]:
        raise Fault(f"it has the tags {got['tags']}")
    used, wait = set(), named([got["paths"], {"security": got["security"]}])
    while wait:
        name = wait.pop()
        kind, key = name.split("/", 1)
        if key not in got["components"][kind]:
            raise Fault(f"it refers to {name}, which it has not")
        used.add(name)
        wait |= named(got["components"][kind][key]) - used
    more = {f"{kind}/{key}" for kind, names in got["components"].items() for key in names} - used
    if more:
        raise Fault(f"it has {sorted(more)}, to which nothing refers")


def run(base):
    document, passed, failed = Document(TOP / "api/call/openapi.yaml"), 0, 0
    jobs = [(example, case) for case in cases(document)]
    posts = {path: good(item["post"])[1]["content"] for path, item in document.document["paths"].items() if "post" in item}
    jobs += [(carried, case[1:4]) for _, case in jobs if case[0] == "post" and case[4] == "application/json" and "application/x-npz" in posts[case[1]]]
    listed = json.loads(ask(base + "/v1/presets", "get", None, "application/json")[2])
    jobs += [(preset, (item["name"],)) for item in listed["presets"]]
    names = [tag["name"] for tag in document.document["tags"]]
    jobs += [(tagged, (path, *tags)) for path in ("/openapi.json", "/openapi-3.0.json") for tags in ([name] for name in names)]
    jobs += [(tagged, ("/openapi.json", "compute", "jobs"))]
    for job, arguments in jobs:
        try:
            job(document, base, *arguments)
            passed += 1
        except Fault as fault:
            failed += 1
            print("FAIL", job.__name__, *(argument for argument in arguments if isinstance(argument, str)), fault)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as home, daemon(sys.argv[1], "--store", f"sqlite:{home}/store.db") as server:
        sys.exit(run(f"http://127.0.0.1:{server.port}"))
