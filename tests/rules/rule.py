"""Helpers of the rules in Python: the count of faults, the paths of helpers, and the shipped nginx configuration.

Leaves to others: daemons and servers (tests/load/servers.py), the checks (the rules). Invariant: every fault and every
skipped test is printed with its reason, and the last line counts all.
"""
import importlib
import pathlib
import re
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


def replaced(config, changes):
    """The text with each of the changes (old, new), all of which have to be possible."""
    for old, new in changes:
        check(f"nginx.conf has {old.strip()!r}", old in config)
        config = config.replace(old, new)
    return config


def shipped_nginx(ports, names=None, changes=(), file="nginx.conf"):
    """A configuration of docker/ for servers.nginx, with one worker and files of its own.

    ports    of daemons on 127.0.0.1, or their addresses; several stand in the shipped block of addresses; with `names` the one port of daemons whose addresses are looked up there.
    names    a names.Names, asked in place of Docker's name server.
    changes  further (old, new) of the text.
    """
    own = [("pid /tmp/", "pid @DIR@/"), ("_temp_path /tmp/", "_temp_path @DIR@/"), ("listen 8080", "listen 127.0.0.1:@PORT@"),
           ("worker_processes auto", "worker_processes 1")]
    if file == "nginx.conf":
        own += [("worker_connections 8192", "worker_connections 2048")]
    if names:
        own += [("resolver 127.0.0.11 ", f"resolver 127.0.0.1:{names.port} "), ("pendulumd:8080;", f"pendulumd:{ports[0]};")]
    elif len(ports) == 1:
        own += [("pendulumd:8080;", f"127.0.0.1:{ports[0]};")]
    else:
        # daemons of one machine that have a port each cannot be told apart by a name; a group of them behaves as its addresses do
        block = (TOP / "docker/nginx.upstream.conf").read_text()
        end = re.search(r"server 10\.0\.0\.1:8080(.*)\n", block)[1]
        group = "".join(f"    server {port if ':' in str(port) else f'127.0.0.1:{port}'}{end}\n" for port in ports)
        block = re.sub(r"(    server 10\..*\n)+", group, block)
        own += [("    server {", f"{block}\n    server {{"), ("pendulumd:8080;", "pendulumd;")]
    return replaced((TOP / "docker" / file).read_text(), [*own, *changes])
