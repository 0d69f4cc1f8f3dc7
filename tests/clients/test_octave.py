"""The Octave client against a live server: its README, and client.m.

Leaves to others: MATLAB, which is not free. Invariant: where Octave is not installed it is skipped aloud.
"""
import os
import re
import subprocess

from clients import TOP, programs
from front import PAGE, Front
from rule import OCTAVE, check, skip


def test_octave(server, home):
    if not OCTAVE:
        skip("the Octave client", "Octave is not installed")
        return None
    folder, out = TOP / "api/clients/octave", home / "octave.doubles"
    refusing, cutting, pages = (Front(server.port) for _ in range(3))
    pages.moods = [PAGE] * 9
    refusing.moods = [("refuse", "429 Too Many Requests", "Retry-After: 1"), ("refuse", "503 Service Unavailable", "Retry-After: 0")]
    cutting.moods = [("pass",), ("cut", 20000), ("cut", 30000)]
    done = subprocess.run([OCTAVE, "--norc", "--quiet", TOP / "tests/clients/client.m", folder, TOP / "tests/golden/paper_example.txt",
                           refusing.url, cutting.url, out, pages.url], capture_output=True, text=True, timeout=300, env=os.environ | {"LC_ALL": "C.UTF-8"})
    lines = done.stdout.splitlines()
    for line in lines:
        check(f"octave: {line.partition(' ')[2]}", line.startswith("ok "), done.stderr[-500:])
    check("octave: the script comes to its end", done.returncode == 0 and len(lines) == 37, f"{len(lines)} checks; {done.stderr[-2000:]}")
    check("octave: what was cut is asked for by Range", sum("Range: bytes=" in head for head in cutting.heads) == 2, cutting.heads)
    check("octave: two refusals were met", len(refusing.heads) == 3, refusing.heads)
    for front in (refusing, cutting, pages):
        front.close()
    programs("octave", [OCTAVE, "--norc", "--quiet", "--path", str(folder), "--eval"])
    return out.read_bytes() if out.exists() else None
