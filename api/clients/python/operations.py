"""Writes pendulumd/operations.py, the client's methods with their parameters, from api/call/openapi.yaml.

usage: operations.py > pendulumd/operations.py     after every change of the document; tests/clients/test_python.py compares
Leaves to others: how a method asks (pendulumd/pendulum.py). Invariant: a field that the document has is a parameter, and no other.
"""
import json
import pathlib
import re
import textwrap

import yaml

# method, route, fields that pendulum.py gives another form, and how that form is described
METHODS = [("run", "trajectories"), ("forces", "forces"), ("tree", "trees"), ("modes", "modes"), ("ensemble", "ensembles"), ("lyapunov", "lyapunov"), ("section", "sections"),
           ("response", "response"), ("controller", "controllers"), ("orbits", "orbits"), ("fits", "fits"), ("tables", "tables"), ("equations", "equations")]
STATE = {"theta": ("ArrayLike", "Angles from hanging, of the start."), "thetad": ("ArrayLike", "Angular velocities of the start."),
         "phi": ("ArrayLike", "Angles from the positive real axis, instead of theta."), "phid": ("ArrayLike", "Angular velocities, instead of thetad."),
         "unit": ('Literal["rad", "deg"]', "Unit of the start's angles.")}
MODE = {"mode": ("int", "Start in this mode, with `amplitude`, instead of angles."), "amplitude": ("float", "Amplitude of the mode of the start.")}
LEADING = {"run": ("times", "Any", '"start:stop:step", "start:stop/count", an array of instants, or a dict of the interface.'),
           "fits": ("csv", "Any", "A table: a file's path, a pandas.DataFrame or a dict of columns; or a list of these, a run each."),
           "tables": ("csv", "Any", "A table: a file's path, a pandas.DataFrame or a dict of columns; or a list of these, a run each.")}


def first_sentence(text):
    """The first sentence of a description, without links."""
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", " ".join(text.split())).partition(" | ")[0]
    found = re.match(r"(.*?[^.A-Z0-9][.!?])(?= [A-Z`]|$)", text + " ")
    sentence = (found[1] if found else text.rstrip(".") + ".").strip()
    return sentence if len(sentence) < 200 or ": " not in sentence[40:] else sentence[:sentence.index(": ", 40)] + "."


def kind_of(schema, schemas):
    """The Python type of a schema: numbers, words, arrays of numbers; Any for the rest."""
    if "$ref" in schema:
        return kind_of(schemas[schema["$ref"].rpartition("/")[2]] | {key: value for key, value in schema.items() if key != "$ref"}, schemas)
    if "enum" in schema:
        return f"Literal[{', '.join(json.dumps(word) for word in schema['enum'])}]"
    kind = schema.get("type")
    if kind == "array":
        inner = kind_of(schema.get("items", {}), schemas)
        return "ArrayLike" if inner in ("float", "int", "ArrayLike") else f"Sequence[{inner}]"
    return {"number": "float", "integer": "int", "boolean": "bool", "string": "str", "object": "Mapping[str, Any]"}.get(kind, "Any") if isinstance(kind, str) else "Any"


def parameters(method, schema, schemas):
    """(name, type, description) of the keyword parameters of a method."""
    for name, field in schema["properties"].items():
        if name == "pendulum" or field.get("deprecated") or name in LEADING.get(method, ()):
            continue
        described = field.get("description") or schemas.get(field.get("$ref", "").rpartition("/")[2], {}).get("description", "")
        if name == "initial":
            yield from ((key, *value) for key, value in STATE.items())
            if method != "orbits":
                yield from ((key, *value) for key, value in MODE.items())
        yield name, kind_of(field, schemas), first_sentence(described) if described else ""


def method_text(method, operation, schema, schemas):
    lines = [f"    def {method}(", "        self,"]
    found = [one for one in dict((one[0], one) for one in parameters(method, schema, schemas)).values()]
    if method in LEADING:
        name, kind, _ = LEADING[method]
        lines.append(f"        {name}: {kind}{'' if method == 'run' else ' = None'},")
    lines.append("        *,")
    lines += [f"        {name}: Optional[{kind}] = None," for name, kind, _ in found]
    lines += ["        job: Union[bool, str] = False,", "        title: Optional[str] = None,", "        save: Any = None,", "        **fields: Any,", "    ) -> Any:"]
    doc = [first_sentence(operation.get("summary", "") or operation["description"]), ""]
    leading = [LEADING[method]] if method in LEADING else []
    for name, _, text in [*leading, *found]:
        doc += textwrap.wrap(f"{name}: {text}", 150, subsequent_indent="    ")
    doc += ["job: True, or a key of your own: a Job is returned at once.", "title: A name of the job in lists.", "save: A file's path, whose suffix is the format; the path is returned."]
    lines.append('        """' + "\n        ".join([doc[0], *doc[1:]]).replace("\\", "\\\\").replace("\n        \n", "\n\n") + '\n        """')
    lines.append("        given = dict(locals())")
    lines.append(f'        return self._method("{method}", given)')
    return "\n".join(lines)


def main():
    document = yaml.safe_load((pathlib.Path(__file__).resolve().parents[2] / "call/openapi.yaml").read_text(encoding="utf-8"))
    schemas = document["components"]["schemas"]
    print('"""The operations of a pendulumd server as methods with their parameters. Written by operations.py from the OpenAPI document.\n\n'
          "Leaves to others: asking (pendulum.py). Invariant: a field that is not named here goes to the server unchanged.\n"
          '"""\nfrom __future__ import annotations\n\nfrom collections.abc import Mapping, Sequence\nfrom typing import TYPE_CHECKING, Any, Literal, Optional, Union\n\n'
          "if TYPE_CHECKING:\n    from numpy.typing import ArrayLike\n\nROUTES = " + json.dumps(dict(METHODS)) + "\n\n\nclass Operations:\n"
          '    """Methods of a Pendulum."""\n\n    def _method(self, name: str, given: dict[str, Any]) -> Any:\n        raise NotImplementedError\n')
    texts = []
    for method, route in METHODS:
        operation = document["paths"][f"/v1/{route}"]["post"]
        schema = operation["requestBody"]["content"]["application/json"]["schema"]
        texts.append(method_text(method, operation, schemas[schema["$ref"].rpartition("/")[2]], schemas))
    print("\n\n".join(texts))


if __name__ == "__main__":
    main()
