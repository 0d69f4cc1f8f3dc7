"""Turns the OpenAPI document into what is compiled in.

    openapi_embed.py api/call/openapi.yaml           C source that defines what api/call/openapi.h declares
    openapi_embed.py --json api/call/openapi.yaml    the JSON itself
    openapi_embed.py --twin api/call/openapi.yaml    the same as OpenAPI 3.0, as JSON

The YAML is read as YAML 1.2's JSON schema has it (no dates, no yes or no, 1e-16 is a number), with the merge keys of 1.1; a
key that is there twice is an error; keys keep their order.
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
    own, merged = {}, {}
    for key, value in node.value:
        if key.value in own:
            raise yaml.constructor.ConstructorError(None, None, f"the key {key.value!r} is there twice", key.start_mark)
        if key.value == "<<":
            merged = loader.construct_object(value, deep=True)
        else:
            own[key.value] = loader.construct_object(value, deep=True)
    return {**own, **{key: value for key, value in merged.items() if key not in own}}


Loader.add_constructor("tag:yaml.org,2002:map", mapping)
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(node.value))


def load(path):
    """The document as Python values, with what many routes share written out at each."""
    with open(path, encoding="utf-8") as file:
        document = yaml.load(file, Loader)
    return {name: value for name, value in document.items() if name != "x-shared"}


def minified(document):
    return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def typed(schema, types):
    """What OpenAPI 3.0 has for a list of types: one, others beside it, and null as a word of its own."""
    real = [one for one in types if one != "null"]
    more = {"nullable": True} if len(real) < len(types) else {}
    if len(real) == 1:
        schema.update(type=real[0], **more)
    else:
        schema.setdefault("anyOf", [{"type": one, **({"items": {}} if one == "array" else {}), **more} for one in real])


def older_limits(schema):
    """Bounds, constants and examples as the schemas of OpenAPI 3.0 have them."""
    for bound, word in (("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")):
        if word in schema and bound not in schema:
            schema[bound], schema[word] = schema[word], True
        elif word in schema:
            del schema[word]
    if "const" in schema:
        schema["enum"] = [schema.pop("const")]
        if "type" not in schema:
            schema["type"] = {bool: "boolean", int: "integer", float: "number"}.get(type(schema["enum"][0]), "string")
    if "examples" in schema:
        examples = schema.pop("examples")
        schema.setdefault("example", examples[0])


def older_schema(schema):
    """A schema of OpenAPI 3.1 in the words of 3.0; what 3.0 cannot say is left out, so that it allows more, never less."""
    if schema is True:
        return {}
    if schema is False:
        return {"not": {}}
    schema = {key: value for key, value in schema.items()
              if key not in ("contentMediaType", "contentEncoding", "if", "then", "else", "$comment", "propertyNames", "unevaluatedProperties",
                             "dependentRequired", "patternProperties", "contains", "minContains", "maxContains")}
    if "$ref" in schema:
        rest = {key: value for key, value in schema.items() if key != "$ref"}
        return {"allOf": [{"$ref": schema["$ref"]}], **older_schema(rest)} if rest else schema
    tuple_of = schema.pop("prefixItems", None)
    if tuple_of:
        schema["items"] = {"anyOf": tuple_of}
    older_limits(schema)
    if isinstance(schema.get("type"), list):
        typed(schema, schema.pop("type"))
    for key in ("items", "additionalProperties", "not"):
        if isinstance(schema.get(key), (dict, bool)) and not (key == "additionalProperties" and isinstance(schema[key], bool)):
            schema[key] = older_schema(schema[key])
    for key in ("allOf", "anyOf", "oneOf"):
        if key in schema:
            schema[key] = [older_schema(one) for one in schema[key]]
    if schema.get("type") == "null":
        schema.update(type="string", nullable=True, enum=[None])
    if "properties" in schema:
        schema["properties"] = {name: older_schema(one) for name, one in schema["properties"].items()}
    if schema.get("type") == "array":
        schema.setdefault("items", {})
    return schema


def older(node, key=None):
    """The document as OpenAPI 3.0, for programs that know no later one: the same routes, fields and words."""
    if isinstance(node, list):
        return [older(one) for one in node]
    if not isinstance(node, dict) or key in ("example", "examples", "value"):
        return node
    if "$ref" in node and isinstance(node["$ref"], str):
        return {"$ref": node["$ref"]}
    return {name: older_schema(value) if name == "schema" else {one: older_schema(its) for one, its in value.items()} if name == "schemas"
            else older(value, name) for name, value in node.items()}


def twin(document):
    made = older({name: value for name, value in document.items() if name != "jsonSchemaDialect"})
    info = {name: value for name, value in made["info"].items() if name != "summary"}
    info["license"] = {name: value for name, value in info["license"].items() if name != "identifier"}
    return {**made, "openapi": "3.0.3", "info": info}


# sections of the description that only these tags need
SECTIONS = {"Jobs": ["compute", "jobs"], "Classes": ["classes"]}


def named(node):
    """The components that a part of the document refers to, as KIND/NAME."""
    if isinstance(node, list):
        return set().union(*map(named, node)) if node else set()
    if not isinstance(node, dict):
        return set()
    own = {node["$ref"].removeprefix("#/components/")} if isinstance(node.get("$ref"), str) else set()
    keys = {f"securitySchemes/{name}" for one in node.get("security", []) if isinstance(one, dict) for name in one}
    return own.union(keys, *map(named, node.values()))


def tags_of(document):
    """The tags, as bits, of each path and of each component that an operation of the path needs."""
    bits = {tag["name"]: 1 << i for i, tag in enumerate(document["tags"])}
    components = {f"{kind}/{name}": one for kind, names in document["components"].items() for name, one in names.items()}
    needs = {name: named(one) for name, one in components.items()}
    paths = {path: sum({bits[tag] for one in item.values() if isinstance(one, dict) for tag in one["tags"]}) for path, item in document["paths"].items()}
    tags = dict.fromkeys(components, 0)
    for path, item in document["paths"].items():
        wait = named([item, {"security": document.get("security", [])}])
        while wait:
            name = wait.pop()
            if tags[name] & paths[path] != paths[path]:
                tags[name] |= paths[path]
                wait |= needs[name]
    return bits, paths, tags


def pieces(document):
    """The minified document as pieces (text, tags that need it as bits); a piece begins with the comma before it."""
    bits, paths, tags = tags_of(document)
    every = (1 << len(bits)) - 1

    def members(items, tags_of_one):
        for i, (key, value) in enumerate(items):
            yield f'{"," if i else ""}{minified(key) + ":" if key else ""}{minified(value)}', tags_of_one(key or value["name"])

    yield "{", every
    for i, (key, value) in enumerate(document.items()):
        yield f'{"," if i else ""}{minified(key)}:', every
        if key == "info":
            # within the text of the description
            for part in re.split(r"(?=\\n\\n## )", minified(value)):
                yield part, sum(bits[tag] for tag in SECTIONS.get((re.match(r"\\n\\n## (\w+)\\n", part) or [0, ""])[1], [])) or every
        elif key == "tags":
            yield "[", every
            yield from members([(None, tag) for tag in value], bits.get)
            yield "]", every
        elif key == "paths":
            yield "{", every
            yield from members(value.items(), paths.get)
            yield "}", every
        elif key == "components":
            yield "{", every
            for kind, names in value.items():
                yield f'{"," if kind != next(iter(value)) else ""}{minified(kind)}:{{', every
                yield from members(names.items(), lambda name, kind=kind: tags[f"{kind}/{name}"])
                yield "}", every
            yield "}", every
        else:
            yield minified(value), every
    yield "}", every


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


def define(name, data):
    print(f"\nstatic const char {name}[] =")
    print("\n".join(f"    {line}" for line in c_literals(data)) + ";")


def main(arguments):
    document = load(arguments[-1])
    if arguments[0] in ("--json", "--twin"):
        print(minified(document if arguments[0] == "--json" else twin(document)))
        return
    print('#include "api/call/openapi.h"')
    names = [tag["name"] for tag in document["tags"]]
    print(f"\nconst char *const api_openapi_tags[] = {{{', '.join(minified(name) for name in names)}, NULL}};")
    print(f"const char api_openapi_names[] = \"{', '.join(names)}\";")
    rows = []
    for name, one in (("latest", document), ("twin", twin(document))):
        data = minified(one).encode()
        cut = [(text.encode(), tags) for text, tags in pieces(one)]
        assert b"".join(text for text, _ in cut) == data
        packed = gzip.compress(data, 9, mtime=0)
        define(name, data)
        define(f"{name}_packed", packed)
        print(f"\nstatic const unsigned {name}_pieces[][2] = {{" + ", ".join(f"{{{len(text)}, {tags}}}" for text, tags in cut) + "};")
        rows.append(f'{{{name}, {name}_packed, "\\"{hashlib.sha256(data).hexdigest()[:32]}\\"", {len(data)}, {len(packed)}, {name}_pieces, {len(cut)}}}')
    print("\nconst struct api_openapi api_openapi[2] = {" + ", ".join(rows) + "};")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
