#!/bin/bash
# Compares documents with code: options, limits, methods, routes; every path, link and identifier in a document must
# exist. --write updates the table of options.
# usage: docs.sh BUILD [--write]     (build/release, for the help)
# Leaves to others: whether replies obey api/call/openapi.yaml (replies.py).
# Invariant: every list has one home in the code; a document with a different list fails.
set -u
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 - "$@" <<'END'
import os, re, subprocess, sys
from fnmatch import fnmatch
from pathlib import Path
import yaml

build, write = sys.argv[1], "--write" in sys.argv
counts = {True: 0, False: 0}


def text(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def same(what, code, document):
    """Both must be the same collection, and not empty."""
    code, document = set(code), set(document)
    good = bool(code) and code == document
    counts[good] += 1
    if not good:
        for item in sorted(map(str, code - document)) or ["nothing"]:
            print(f"  only in the code: {item}")
        for item in sorted(map(str, document - code)) or ["nothing"]:
            print(f"  only in the document: {item}")
        print(f"FAIL {what}")


def first_cells(markdown, header):
    """What stands in backticks in the first column of the table under a header line."""
    rows = markdown.split(header, 1)[1].split("\n\n", 1)[0].splitlines()[2:]
    return [re.match(r"\| `([^`]+)`", row).group(1) for row in rows if row.startswith("| `")]


def walk(node):
    yield node
    for child in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from walk(child)


openapi = yaml.safe_load(text("api/call/openapi.yaml"))

# options: the help as a table, in docker/README.md
page = text("docker/README.md")
begin, end = "<!-- options -->\n", "<!-- end of options -->"
before, rest = page.split(begin)
old, after = rest.split(end)
table = subprocess.run([f"{build}/pendulumd", "--help=markdown"], capture_output=True, text=True, check=True).stdout
if write:
    with open("docker/README.md", "w", encoding="utf-8") as file:
        file.write(before + begin + table + end + after)
    old = table
same("options in docker/README.md", table.splitlines(), old.splitlines())

# routes: the router's table, the README, the paths of the OpenAPI document
router = re.findall(r'ROUTER_\w+\("(GET|POST|PUT|DELETE)", "(/[^"]*)"', text("server/http/router.c"))
routes = {f"{method} {path}" for method, path in router}
verbs = ("get", "post", "put", "delete")
paths = {f"{verb.upper()} {path}" for path, item in openapi["paths"].items() for verb in item if verb in verbs}
same("routes in api/call/openapi.yaml", routes, paths)

# methods: the descriptors of the core
source = "".join(path.read_text(encoding="utf-8") for path in sorted(Path("core").rglob("method_*.c")))
methods = set(re.findall(r'\.name = "(\w+)"', source)) | set(re.findall(r"GSL_STEPPER\(\s*(\w+),", source.replace("GSL_STEPPER(name_", "")))
same("methods in the guide", methods, first_cells(text("api/guide/motions.md"), "| method | what it is |"))
enums = [node["enum"] for node in walk(openapi) if isinstance(node, dict) and "taylor" in (node.get("enum") or ())]
same("methods in api/call/openapi.yaml", methods, set().union(*enums) if enums else ())

# limits: name and default, in any sentence of the OpenAPI document
limits = re.findall(r'X\(\w+, "(max-[\w-]+)", (\d+),', text("api/base/limits.h"))
sentences = " ".join(node for node in walk(openapi) if isinstance(node, str))
told = [(name, value) for name, value in limits if re.search(rf"{name}\W[^.]*?\b{value}\b", sentences)]
same("limits in api/call/openapi.yaml", limits, told)

# kinds of problems and of faults: the words of problem.c, the tables and the schemas of the OpenAPI document
kinds = dict(re.findall(r"\{'(\w)', \"([\w-]+)\"\}", text("api/base/problem.c")))
told = openapi["info"]["description"]
types = {f"urn:pendulumd:problem-{word}" for letter, word in kinds.items() if letter.isupper()}
codes = {word for letter, word in kinds.items() if letter.islower()} | {"invalid"}
same("problems in api/call/openapi.yaml", types, {f"urn:pendulumd:problem-{word}" for word in first_cells(told, "| problem | status | what |")})
same("codes in api/call/openapi.yaml", codes, first_cells(told, "| code | what is wrong |"))
same("types of a Problem", types | {"about:blank"}, openapi["components"]["schemas"]["Problem"]["properties"]["type"]["enum"])
same("codes of a Fault", codes, openapi["components"]["schemas"]["Fault"]["properties"]["code"]["enum"])
stated = set(re.findall(r'define API_(?:CODE|TYPE)_\w+ "\\1(\w)"', text("api/base/problem.h")))
same("letters of kinds in problem.h", set(kinds), stated)

# what documents name: links and their headings, paths, identifiers. In names X, ROOM, FOLDER and NAME stand for any.
PLACES = ("api", "core", "debian", "docker", "server", "tests")
SOURCES = (".c", ".h", ".cpp", ".py", ".m", ".sh", ".js", ".ts", ".mjs", ".yaml", ".yml", ".mk", ".conf", ".css", ".html", ".sbatch", ".service")
ANY = re.compile(r"(?<![A-Za-z0-9])(?:X|ROOM|FOLDER|NAME)(?![A-Za-z0-9])|[*]")
FILE = re.compile(r"[\w.{}*/-]+\.(?:cpp|c|h|py|sh|mjs|js|yaml|mk|md|conf|sbatch)")


def tree_of_files():
    for place in PLACES:
        for folder, folders, names in os.walk(place):
            folders[:] = [f for f in folders if f not in ("node_modules", "__pycache__")]
            yield from (f"{folder}/{name}" for name in names + folders)


everything = sorted({*os.listdir("."), *PLACES, *tree_of_files()})
documents = [path for path in everything if path.endswith(".md")]
words = set()
for path in everything:
    if path != "tests/rules/docs.sh" and (path.endswith(SOURCES) or path in ("Makefile", "docker/Dockerfile")):
        words.update(re.findall(r"\w+", text(path)) if Path(path).is_file() else ())
stems = {re.sub(r"\.\w+$", "", Path(path).name) for path in everything}


def exists(name, home):
    """Whether a path, with an ending or without, is there: from the document's folder, from its room,
    from the room that its tests are of, or from the top."""
    name = ANY.sub("*", name.rstrip("/"))
    for start in {home + "/", home.partition("/")[0] + "/", home.removeprefix("tests/") + "/", ""}:
        whole = os.path.normpath(start + name)
        if any(fnmatch(path, whole) or fnmatch(path, whole + ".*") for path in everything):
            return True
    return "/" not in name and any(fnmatch(Path(path).name, name) for path in everything)


def known(word):
    if word in words or word in stems:
        return True
    return bool(ANY.search(word)) and any(fnmatch(w, ANY.sub("*", word)) for w in words)


def headings(path):
    for heading in re.findall(r"(?m)^#+ +(.*)", text(path)):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def stale(path, markdown):
    """What a document names that is not there."""
    home = str(Path(path).parent).removeprefix(".")
    prose = re.sub(r"(?ms)^```.*?^```", "", markdown)
    for target in re.findall(r"\]\(([^)\s]+)\)", prose):
        file, _, heading = target.partition("#")
        place = os.path.normpath(f"{home or '.'}/{file}") if file else path
        if re.match(r"\w+:", target):
            continue
        if not os.path.exists(place):
            yield f"links to {target}"
        elif heading and heading not in headings(place):
            yield f"links to {target}, which has no such heading"
    for target in re.findall(r"`make ((?!check\b)[a-z][a-z-]*)", prose):
        if not re.search(rf"(?m)^(?:[a-z -]* )?{target}(?: [a-z -]*)?:|^ROOMS :=.* {target.removeprefix('test-')}\b", text("Makefile")):
            yield f"names make {target}"
    for name in re.findall(r"`([^`\n]+)`", prose):
        first = name.split()[0].split("=")[-1].rstrip(",;:")
        if FILE.fullmatch(first) or re.fullmatch(r"(?:[\w{}*-]+/)+[\w{}*-]*", first):
            if not first.startswith(("/", "build/")) and not exists(first, home) and not re.fullmatch(r"(?:application|text|image)/.+|\w+/\w+/\w+", first):
                yield f"names the path {first}"
            continue
        for word in re.findall(r"\b(?:pend|api|srv|PEND|API|SRV)_\w+|\b\w+(?=\()|^[a-z]+(?:_[a-z0-9]+)+$", name):
            if not known(word):
                yield f"names {word}"


# a sample in which every kind of stale name is noticed, and no other
fresh = "`core/tree/tree.c` `tree/tree` `tree.h` `test_X.c` `pend_tree_new` `api_op_X` `tree_store` [a](README.md#invariants) `make bench-page` `make test-core T=tree` `GET /v1/no` `image/png`"
wrong = ("`core/tree/no.c`", "`tree/no`", "`no_such.h`", "`no_X_such.c`", "`pend_no_such`", "`no_such(a)`", "`no_such_word`", "`make no`", "[a](no.md)", "[a](README.md#no)")
for each, count in [(fresh, 0), *((name, 1) for name in wrong)]:
    found = list(stale("core/README.md", each))
    counts[len(found) == count] += 1
    if len(found) != count:
        print(f"FAIL of {each} the rule says {found}")

for path in documents:
    complaints = list(stale(path, text(path)))
    counts[not complaints] += 1
    for complaint in complaints:
        print(f"  {path} {complaint}")
    if complaints:
        print(f"FAIL {path} names what is not there")

print(f"{counts[True]} passed, {counts[False]} failed")
sys.exit(counts[False] > 0)
END
