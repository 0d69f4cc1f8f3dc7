#!/usr/bin/python3
"""Reads and writes the corpora of tests/fuzz/corpus: one input per line, shortest first.

usage: corpus.py unpack READER DIRECTORY    writes each line to a file
       corpus.py pack READER DIRECTORY      writes the files, as left by libFuzzer's -merge=1, as lines
       corpus.py add READER FILE...         adds inputs that failed
Backslashes, and bytes that are not printable ASCII, are written as \\xNN, which fuzz.c reads.
Leaves to others: running readers on inputs (fuzz_X.c), finding inputs (run.sh).
Invariant: unpacking restores the packed bytes; a corpus has at most 40 000 bytes, and earlier inputs are kept first.
"""
import hashlib
import pathlib
import sys

CORPUS = pathlib.Path(__file__).parent / "corpus"
MOST, LONGEST = 40000, 2000


def line(data):
    return "".join(chr(c) if 32 <= c < 127 and c != 92 else f"\\x{c:02x}" for c in data)


def data(text):
    out, at = bytearray(), 0
    while at < len(text):
        if text[at] == "\\":
            out.append(int(text[at + 2:at + 4], 16))
            at += 4
        else:
            out.append(ord(text[at]))
            at += 1
    return bytes(out)


def read(reader):
    path = CORPUS / reader
    return [data(text) for text in path.read_text(encoding="ascii").split("\n")[:-1]] if path.exists() else []


def write(reader, inputs):
    lines = sorted({line(each) for each in inputs}, key=lambda text: (len(text), text))
    for text in lines:
        if line(data(text)) != text:
            sys.exit(f"{reader}: {text} is not read as it was written")
    CORPUS.mkdir(exist_ok=True)
    (CORPUS / reader).write_text("".join(text + "\n" for text in lines), encoding="ascii")


def main():
    if len(sys.argv) < 4 or sys.argv[1] not in ("pack", "unpack", "add"):
        sys.exit(__doc__)
    way, reader, places = sys.argv[1], sys.argv[2], [pathlib.Path(name) for name in sys.argv[3:]]
    kept = read(reader)
    if way == "unpack":
        for each in kept:
            (places[0] / hashlib.sha1(each).hexdigest()).write_bytes(each)
        return
    more = [path.read_bytes() for place in places for path in (sorted(place.iterdir()) if place.is_dir() else [place])]
    room = MOST - sum(len(line(each)) + 1 for each in kept)
    for each in sorted(set(more) - set(kept), key=len):
        room -= len(line(each)) + 1
        if way == "add" or (room >= 0 and len(each) <= LONGEST):
            kept.append(each)
    write(reader, kept)


main()
