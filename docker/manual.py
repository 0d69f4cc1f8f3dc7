#!/usr/bin/python3
"""Writes pendulumd(8) from what the program says of itself.

usage: manual.py PROGRAM > pendulumd.8
Leaves to others: the options and their words (server/config/config; `pendulumd --help`, `pendulumd keys`).
Invariant: an option that the program has is in the page, with its words and its default.
"""
import re
import subprocess
import sys

OPTION = re.compile(r"  (--[a-z-]+) ?(\S*)$")


def roff(text):
    """A text as roff takes it: no escapes, no requests at the beginning of a line."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.M)


def told(*command):
    """What the program prints, whatever its status is."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.stdout


def options(text):
    """The options of a help text, in its order: their names, their values, their words."""
    found = []
    for line in text.splitlines():
        option = OPTION.match(line)
        if option:
            found.append([option[1], option[2], []])
        elif found and line.startswith("      "):
            found[-1][2].append(line.strip())
    return found


def main(program):
    """The page, on standard output."""
    version = told(program, "--version").split()[1]
    text = told(program, "--help")
    head, _, _ = text.partition("\n  --")
    listed = options(text)
    if len(listed) < 50:
        sys.exit(f"manual.py: {program} --help lists {len(listed)} options only")
    out = [f'.TH PENDULUMD 8 "" "pendulumd {version}" "System administration"',
           ".SH NAME", "pendulumd \\- server for planar pendulum trees",
           ".SH SYNOPSIS", ".B pendulumd", ".RB [ \\-\\-option", ".IR value ]...", ".br", ".B pendulumd keys",
           ".IR action ...", ".br", ".B pendulumd healthy", ".RB [ \\-\\-option", ".IR value ]...", ".SH DESCRIPTION"]
    out += [roff(paragraph) + "\n.PP" for paragraph in head.split("\n", 1)[1].strip().split("\n\n")]
    out += ["SIGTERM lets what runs finish and ends the server, SIGHUP has it read its options again. The word", ".B healthy",
            "has it ask the server that has the same options for /healthz, and end with status 0 where the answer is 200.", ".SH OPTIONS"]
    for name, value, words in listed:
        out += [".TP", f".B {roff(name)}" if not value else f'.BI {roff(name)} " {roff(value)}"', roff(" ".join(words))]
    out += [".SH KEYS", ".nf", roff(told(program, "keys").strip()), ".fi",
            ".SH FILES", ".TP", ".I /etc/default/pendulumd", "options for the systemd unit, as in PENDULUMD_MAX_QUEUE=10",
            ".TP", ".I /var/lib/pendulumd/store.db", "jobs, scenes and rooms, where the unit keeps them",
            ".SH SEE ALSO", ".BR pendulum (1)"]
    print("\n".join(out))


main(sys.argv[1])
