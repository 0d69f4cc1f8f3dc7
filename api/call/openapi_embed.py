"""Turns the OpenAPI document into what is compiled in.

    openapi_embed.py api/call/openapi.yaml           C source that defines what api/call/openapi.h declares
    openapi_embed.py --json api/call/openapi.yaml    the JSON itself

The YAML is read as YAML 1.2's JSON schema has it (no dates, no yes or no, 1e-16 is a number); a key that is there twice
is an error; keys keep their order.
"""
import gzip
import hashlib
import json
import re
import sys

import yaml


class Loader(yaml.SafeLoader):
    """A loader without YAML 1.1's guesses."""

    yaml_implicit_resolvers = {}


for tag, pattern, first in (
    ("null", r"^null$", "n"),
    ("bool", r"^(true|false)$", "tf"),
    ("int", r"^-?(0|[1-9][0-9]*)$", "-0123456789"),
    ("float", r"^-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?$", "-0123456789"),
):
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(pattern), list(first))


def mapping(loader, node):
    keys = set()
    for key, _ in node.value:
        if key.value in keys:
            raise yaml.constructor.ConstructorError(None, None, f"the key {key.value!r} is there twice", key.start_mark)
        keys.add(key.value)
    return {str(loader.construct_object(key)) if key.tag.endswith("int") else loader.construct_object(key):
            loader.construct_object(value, deep=True) for key, value in node.value}


Loader.add_constructor("tag:yaml.org,2002:map", mapping)
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value))


def load(path):
    """The document as Python values."""
    with open(path, encoding="utf-8") as file:
        return yaml.load(file, Loader)


def minified(document):
    return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def c_literals(data, width=100):
    """Lines of C string literals: printable ASCII as it is, all else in octal, no trigraphs."""
    safe = {34: '\\"', 92: "\\\\", 63: "\\?"}
    pieces = [safe.get(b) or (chr(b) if 32 <= b < 127 else f"\\{b:03o}") for b in data]
    line = ""
    for piece in pieces:
        if len(line) + len(piece) > width:
            yield f'"{line}"'
            line = ""
        line += piece
    yield f'"{line}"'


def define(name, data, length):
    print(f"\nconst char {name}[] =")
    print("\n".join(f"    {line}" for line in c_literals(data)) + ";")
    print(f"\nconst size_t {length} = sizeof {name} - 1;")


def main(arguments):
    text = minified(load(arguments[-1]))
    if arguments[0] == "--json":
        print(text)
        return
    data = text.encode()
    print('#include "api/call/openapi.h"')
    define("api_openapi_json", data, "api_openapi_bytes")
    define("api_openapi_packed", gzip.compress(data, 9, mtime=0), "api_openapi_packed_bytes")
    print(f'\nconst char api_openapi_etag[] = "\\"{hashlib.sha256(data).hexdigest()[:32]}\\"";')


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
