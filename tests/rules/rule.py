"""What the rules in Python share: the count of what they found, where their helpers are, and nginx as it is shipped.

Leaves to others: daemons and servers (tests/load/servers.py), what is checked (the rules). Invariant: what fails or is
skipped is said with its reason, and the last line counts all.
"""
import importlib
import pathlib
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(TOP / "tests/load"), str(TOP / "tests/drill")]
from servers import tool  # noqa: E402

OCTAVE = tool("octave-cli") or tool("octave")
counts = {"passed": 0, "failed": 0, "skipped": 0}


def check(what, good, detail=""):
    counts["passed" if good else "failed"] += 1
    if not good:
        print(f"FAIL {what}: {detail}")


def skip(what, why):
    counts["skipped"] += 1
    print(f"skip {what}: {why}")


def summary():
    """Prints the last line; the exit status."""
    print(", ".join(f"{count} {word}" for word, count in counts.items() if count or word != "skipped"))
    return counts["failed"] > 0


def optional(name):
    """The package of a module that was imported, or None where it is not installed."""
    try:
        importlib.import_module(name)
    except ImportError:
        return None
    return sys.modules[name.partition(".")[0]]


def shipped_nginx(ports):
    """docker/nginx.conf for servers.nginx: before daemons at these ports, with one worker and files of its own."""
    config = (TOP / "docker/nginx.conf").read_text()
    for old, new in (("pid /run/", "pid @DIR@/"), ("_temp_path /tmp/", "_temp_path @DIR@/"), ("listen 8080 ", "listen 127.0.0.1:@PORT@ "),
                     ("server pendulumd:8080;", " ".join(f"server 127.0.0.1:{port};" for port in ports)),
                     ("worker_processes auto", "worker_processes 1")):
        check(f"nginx.conf has {old.strip()!r}", old in config)
        config = config.replace(old, new)
    return config
