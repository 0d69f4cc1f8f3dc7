"""Runs the scripts of api/clients/python/tasks, the large ones with smaller numbers, and reads what they say of their results.

Leaves to others: the client (test_python.py), which has to be installed before. Invariant: each runs in a directory of its own; one
that goes on with a job runs twice there.
"""
import os
import subprocess
import sys

from clients import TOP
from rule import check, optional, skip

SMALL = {"dataset": ("20000", "2000"), "flips": ("512", "100"), "figure": ("300", "80")}
SAYS = {"dataset": "(2000, 500) 20 starts within 3 rad: True energies kept: True\n", "flips": "(100, 100) 61% turn over b'\\x89PNG'\n",
        "exponents": "calm below -20 J: True chaotic above 0 J: True\n", "longjob": "(400001, 2) stays below 1 rad: True\n",
        "figure": "none turns over within the curve: True beyond it most do: True\n",
        "gradient": "forwards and backwards agree: True\nas differences say: True\nthe descent finds what made the angles: True\n",
        "sections": "40 orbits, True many points, all at the energy: True\n",
        "masses": "the heavier the second mass, the harder it pulls: True\n"}


def run(script, place, home):
    return subprocess.run([sys.executable, "-B", script], cwd=place, capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": str(home / "python")}, timeout=600)


def test_tasks(server, home):
    if not optional("pendulumd"):
        skip("the tasks", "the Python client comes before them")
        return
    scripts = sorted((TOP / "api/clients/python/tasks").glob("*.py"))
    check("tasks: every script is run", {script.stem for script in scripts} == set(SAYS))
    for script in scripts:
        large, small = SMALL.get(script.stem, ("", ""))
        text, place = script.read_text(encoding="utf-8"), home / script.stem
        place.mkdir()
        check(f"tasks: {script.stem} has the number that is made smaller", large in text)
        own = place / script.name
        own.write_text(text.replace(large, small) if large else text, encoding="utf-8")
        for _ in range(2 if script.stem == "longjob" else 1):
            done = run(own, place, home)
            check(f"tasks: {script.stem}", done.returncode == 0 and done.stdout == SAYS[script.stem], done.stdout + done.stderr[-1000:])
