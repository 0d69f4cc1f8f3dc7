#!/bin/bash
# Compares documents with code: options, limits, methods, routes. With --write it brings the options' table up to date.
# usage: docs.sh BUILD [--write]     (build/release, for the help)
# Leaves to others: whether replies obey api/call/openapi.yaml (replies.py).
# Invariant: every list has one home in the code; a document that tells another list fails.
set -u
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 - "$@" <<'END'
import re, subprocess, sys
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


readme, openapi = text("README.md"), yaml.safe_load(text("api/call/openapi.yaml"))

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
router = re.findall(r'\{"(GET|POST|PUT|DELETE)", "(/[^"]*)"', text("server/http/router.c"))
routes = {f"{method} {path}" for method, path in router}
same("routes in README.md", routes, first_cells(readme, "| route | answers |"))
verbs = ("get", "post", "put", "delete")
paths = {f"{verb.upper()} {path}" for path, item in openapi["paths"].items() for verb in item if verb in verbs}
same("routes in api/call/openapi.yaml", routes, paths)

# methods: the descriptors of the core
source = "".join(text(f"core/integrate/{name}.c") for name in ("method_taylor", "method_ode23", "method_gsl", "method_symplectic", "method_linear"))
methods = set(re.findall(r'\.name = "(\w+)"', source)) | set(re.findall(r"GSL_STEPPER\(\s*(\w+),", source.replace("GSL_STEPPER(name_", "")))
same("methods in README.md", methods, first_cells(readme, "| method | what it is |"))
enums = [node["enum"] for node in walk(openapi) if isinstance(node, dict) and "taylor" in (node.get("enum") or ())]
same("methods in api/call/openapi.yaml", methods, set().union(*enums) if enums else ())

# limits: name and default, in any sentence of the OpenAPI document
limits = re.findall(r'X\(\w+, "(max-[\w-]+)", (\d+),', text("api/base/limits.h"))
sentences = " ".join(node for node in walk(openapi) if isinstance(node, str))
told = [(name, value) for name, value in limits if re.search(rf"{name}\W[^.]*?\b{value}\b", sentences)]
same("limits in api/call/openapi.yaml", limits, told)

print(f"{counts[True]} passed, {counts[False]} failed")
sys.exit(counts[False] > 0)
END
