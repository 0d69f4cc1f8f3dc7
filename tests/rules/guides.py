"""Runs every program of README.md and the guides with a live server, and compares its output with the output printed
below it, in which "..." matches anything and lines may be broken.

usage: guides.py BUILD [PART-OF-A-NAME]     (build/release, for the server; without a name: all)
Leaves to others: the READMEs of the clients (clients.py), the examples of the API's document (examples.py).
Invariant: each file has its own folder; blocks in `console` or another language are not run.
"""
import os
import re
import subprocess
import sys
import tempfile

from rule import TOP, check, optional, skip, summary
from servers import daemon

BLOCK = re.compile(r"```(sh|python|r)\n(.*?)```(?:\n\n```\n(.*?)```)?", re.S)


def fits(shown, output):
    """True if the output is what is shown; blanks and ends of lines do not count."""
    parts = ("".join(part.split()) for part in shown.split("..."))
    return re.fullmatch(".*".join(map(re.escape, parts)), "".join(output.split()), re.S)


def run(path, url, environment):
    blocks = BLOCK.findall(path.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="pendulumd-guides-") as home:
        for number, (language, program, shown) in enumerate(blocks, 1):
            if language == "python" and not optional("numpy"):
                skip(f"{path.name}: program {number}", "NumPy is not installed")
                continue
            if language == "r" and subprocess.run(["Rscript", "--vanilla", "-e", "library(httr2)"], capture_output=True).returncode:
                skip(f"{path.name}: program {number}", "r-cran-httr2 is not installed")
                continue
            command = {"python": ["/usr/bin/python3", "-c"], "sh": ["bash", "-euc"], "r": ["Rscript", "--vanilla", "-e"]}[language]
            done = subprocess.run([*command, program.replace("http://127.0.0.1:8080", url)], capture_output=True, text=True,
                                  timeout=300, cwd=home, env=environment)
            check(f"{path.name}: program {number}", done.returncode == 0 and fits(shown, done.stdout.replace(url, "http://127.0.0.1:8080")),
                  f"\n{program}\n--- prints\n{done.stdout[:3000]}{done.stderr[-2000:]}\n--- the page shows\n{shown}")
    return len(blocks)


build, part = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""
with tempfile.TemporaryDirectory(prefix="pendulumd-guides-") as store, daemon(build, "--store", f"sqlite:{store}/store.db") as server:
    url = f"http://127.0.0.1:{server.port}"
    environment = os.environ | {"PENDULUM_URL": url, "PYTHONPATH": str(TOP / "api/clients/python"), "PENDULUM_LIBRARY": str(TOP / build / "libpendulum.so"), "PATH": f"{TOP / build}:{os.environ['PATH']}"}
    paths = [path for path in (TOP / "README.md", *sorted((TOP / "api/guide").glob("*.md"))) if part in path.name]
    ran = sum(run(path, url, environment) for path in paths)
check("the guides have programs", ran > 0)
sys.exit(summary())
