"""Tests the clients of api/clients with a live server and with each other: the programs of their READMEs and their own tests
run, and all clients must return the same doubles for the paper's example.

usage: clients.py BUILD [NAME...]
Leaves to others: the tests of each client (tests/clients/test_NAME.py); whether the numbers are right (tests/laws).
Invariant: skipped tests are reported; the server ends with the test.
"""
import importlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

sys.modules["clients"] = sys.modules["__main__"]
from rule import TOP, check, optional, skip, summary  # noqa: E402
from servers import daemon, tool  # noqa: E402

sys.path.insert(0, str(TOP / "tests/clients"))

FOUR = {"L": [2, 1.5, 0.75, 1.25], "m": [1, 1, 1, 0.1], "S": [[1, 0, 0, 0], [1, 1, 0, 0], [1, 1, 1, 0], [1, 1, 0, 1]]}
DOUBLE = {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}
CLIENTS = ("python", "envs", "notebook", "tasks", "octave", "cli", "js", "c", "mistakes")


def programs(language, command, extra=None, folder=None, home=None):
    """Runs the programs of a client's README, each with the text that the README shows below it."""
    text = (TOP / "api/clients" / (folder or language) / "README.md").read_text(encoding="utf-8")
    found = re.findall(rf"```{language}\n(.*?)```(?:\n\n```\n(.*?)```)?", text, re.S)
    check(f"{language}: a README begins with a program of five lines", found and text.find("```") < 200
          and len([line for line in found[0][0].splitlines() if line.strip()]) <= 6, text[:300])
    for number, (program, shown) in enumerate(found, 1):
        done = subprocess.run([*command, program], capture_output=True, text=True, env=os.environ | (extra or {}), timeout=300, cwd=home)
        check(f"{language}: program {number} of the README", done.returncode == 0 and (not shown or done.stdout == shown),
              f"{done.stdout}{done.stderr[-2000:]}instead of\n{shown}")


def main():
    build, names = sys.argv[1], sys.argv[2:] or CLIENTS
    brought = {}
    with tempfile.TemporaryDirectory(prefix="pendulumd-clients-") as directory:
        home = pathlib.Path(directory)
        with daemon(build, "--store", f"sqlite:{home}/store.db") as server:
            os.environ |= {"PENDULUM_URL": f"http://127.0.0.1:{server.port}", "PENDULUM_TOKEN": os.urandom(16).hex(),
                           "PENDULUM_BUILD": str(TOP / build)}
            for name in names:
                begin = time.monotonic()
                brought[name] = getattr(importlib.import_module(f"test_{name}"), f"test_{name}")(server, home)
                print(f"{name}: {time.monotonic() - begin:.1f} s")
    came = {name: data for name, data in brought.items() if data}
    for name, data in came.items():
        check(f"{name} brings the same doubles as the others", data == next(iter(came.values())), f"{len(data)} bytes")
    sys.exit(summary())


if __name__ == "__main__":
    if not optional("numpy"):
        skip("the clients", "NumPy is not installed")
        sys.exit(summary())
    main()
