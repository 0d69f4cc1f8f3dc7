"""Runs the cells of the notebooks of api/clients/python, in their order, and compares what they say with what stands in them.

    WRITE_NOTEBOOKS=1 python3 -B tests/rules/clients.py build/release python notebook     puts what they say into them

Leaves to others: the client (test_python.py), which has to be installed before. Invariant: a cell sees only what cells above it have made.
"""
import ast
import base64
import contextlib
import io
import json
import os
import time

from clients import TOP
from rule import check, optional, skip


def shown(value):
    """A value as a notebook shows it: a picture, or a text."""
    if value is None:
        return []
    if hasattr(value, "_repr_png_"):
        data = {"image/png": base64.b64encode(value._repr_png_()).decode(), "text/plain": ["<picture>"]}
    else:
        data = {"text/plain": repr(value).splitlines(keepends=True)}
    return [{"data": data, "execution_count": None, "metadata": {}, "output_type": "execute_result"}]


def run_cell(source, names):
    """The outputs of a cell: what it prints, and its last expression."""
    tree, out, last = ast.parse(source), io.StringIO(), None
    if tree.body and isinstance(tree.body[-1], ast.Expr):
        last = ast.Expression(tree.body.pop().value)
    with contextlib.redirect_stdout(out):
        exec(compile(tree, "<cell>", "exec"), names)
        value = eval(compile(last, "<cell>", "eval"), names) if last else None
    said = [{"name": "stdout", "output_type": "stream", "text": out.getvalue().splitlines(keepends=True)}] if out.getvalue() else []
    return said + shown(value)


def texts(outputs):
    """What is compared: texts, and that there is a picture, whose bytes depend on the version of the library that packs it."""
    return ["".join(output.get("text") or output["data"]["text/plain"]) for output in outputs]


def test_notebook(server, home):
    if not optional("pendulumd"):
        skip("the notebooks", "the Python client comes before them")
        return
    for path in sorted((TOP / "api/clients/python").glob("*.ipynb")):
        begin, names = time.monotonic(), {"__name__": "__main__"}
        book = json.loads(path.read_text(encoding="utf-8"))
        for number, cell in enumerate(book["cells"]):
            if cell["cell_type"] != "code":
                continue
            try:
                outputs = run_cell("".join(cell["source"]), names)
            except Exception as error:
                outputs = [{"text": [f"{type(error).__name__}: {error}"]}]
            if "WRITE_NOTEBOOKS" in os.environ:
                cell["outputs"] = outputs
            check(f"{path.name}: cell {number}", bool(outputs or not cell["outputs"]) and texts(outputs) == texts(cell["outputs"]),
                  f"says {texts(outputs)}, not {texts(cell['outputs'])}")
            for output in outputs:
                if "image/png" in output.get("data", ()):
                    check(f"{path.name}: cell {number} shows a picture", base64.b64decode(output["data"]["image/png"])[1:4] == b"PNG")
        if "WRITE_NOTEBOOKS" in os.environ:
            path.write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(f"{path.name}: {time.monotonic() - begin:.1f} s")
