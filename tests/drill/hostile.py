"""A pupil who means no good, beside two classes at work: everything such a one can do at once, and what the others notice of it.

usage: hostile.py BUILD [--joins N] [--seconds S]        (make hostile: 100000 joins, 20 s of a lesson before and during it)
The pupil knows the code of the first room, asks from an address of its own, and joins again and again; answers with a megabyte;
has scripts for a name and for an answer; writes what is the teacher's or another pupil's, with tokens of another room, of nobody
and of no form; guesses codes; and opens streams of events that it never reads. It tells what came of each, how long the others'
changes took, alone and beside it, and the memory of the daemon; and fails when the others lack a change or are refused anything,
when a try gets an answer that it should not, and when places, guesses, streams or memory go past their bounds.

Leaves to others: single refusals and their sentences (tests/wire/test_classes.c), what a page makes of scripts
(tests/web/test_room.mjs), load without malice (tests/load/classes.py).
Invariant: traffic stays on loopback; what was started ends.
"""
import argparse
import asyncio
import collections
import contextlib
import http.client
import json
import multiprocessing
import pathlib
import random
import re
import socket
import sys
import tempfile
import time

from house import Daemon
from places import place

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(TOP / "tests/rules"), str(TOP / "tests/load")]
from classes import Room  # noqa: E402
from rule import check, summary  # noqa: E402

ROOMS, PUPILS, AT_ONCE = 2, 30, 50
STREAMS = 256  # a quarter of max-event-streams
ADDRESS, OTHER = "127.0.0.2", "127.0.0.3"  # of the pupil, the other one for guesses; the rooms' are 127.0.1.x
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
SCRIPT = "<script>alert(1)</script>"
BURST, A_SECOND, PLACES = 30, 0.5, 400  # wrong codes at once and then; pupils of a room (README.md)
STILL = 60  # s without a change after which those that have not come are lost
GROWTH = 64 << 20  # bytes that the daemon may have more than before
STATUS = re.compile(rb"HTTP/1\.1 (\d{3}) ")


def message(method, path, token="", body=b""):
    fields = f"Class-Token: {token}\r\n" if token else ""
    fields += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n" if body else ""
    return f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n".encode() + body


def connect(port, address=ADDRESS):
    return socket.create_connection(("127.0.0.1", port), 60, (address, 0))


def one(port, *words):
    """Sends one request on a connection of its own; its status, 0 where it only ended."""
    with contextlib.suppress(OSError), connect(port) as line:
        with contextlib.suppress(OSError):  # an answer may come before all was sent
            line.sendall(message(*words))
        found = STATUS.match(line.recv(4096))
        return int(found[1]) if found else 0
    return 0


def many(port, requests, address=ADDRESS):
    """Sends requests one behind the other without waiting for answers; how often each status came."""
    told, line, text = collections.Counter(), None, b""
    for at in range(0, len(requests), AT_ONCE):
        some, heard = requests[at:at + AT_ONCE], 0
        try:
            line = line or connect(port, address)
            line.sendall(b"".join(some))
            while heard < len(some):
                got = line.recv(1 << 16)
                if not got:
                    raise ConnectionError
                text += got
                found = [(int(one[1]), one.end()) for one in STATUS.finditer(text)]
                told.update(status for status, _ in found)
                heard += len(found)
                text = text[found[-1][1]:] if found else text[-16:]
        except OSError:
            told["ended"] += 1
            line, text = None, b""
    return told


def joins(port, path, count):
    return many(port, [message("POST", f"{path}/pupils", "", json.dumps({"nickname": f"{SCRIPT} {i % 7}"}).encode()) for i in range(count)])


def guesses(port, count):
    dice = random.Random(1)
    codes = ["".join(dice.choice(LETTERS) for _ in range(5)) for _ in range(count)]
    return many(port, [message("POST", f"/v1/classes/{code}/pupils", "", b'{"nickname":"Eve"}') for code in codes], OTHER)


def trespasses(port, path, own, foreign):
    """What is not this pupil's: {what: (status, those that it may be)}."""
    nobody, large = "0123456789abcdef0123456789abcdef", b'{"value":"' + b"a" * (1 << 20) + b'"}'
    sheet = json.dumps({"title": SCRIPT, "steps": [{"id": "a", "text": SCRIPT}]}).encode()
    tries = {
        "an answer of 1 MB": (("PUT", f"{path}/answers/q", own, large), (413, 0)),
        "a stage of 1 MB": (("PUT", f"{path}/stages/own", own, large), (413, 0)),
        "a worksheet with a script, by a pupil": (("PUT", f"{path}/worksheets/s", own, sheet), (403,)),
        "a script as an answer to no question": (("PUT", f"{path}/answers/none", own, json.dumps({"value": SCRIPT}).encode()), (409,)),
        "the stage of the class": (("PUT", f"{path}/stages/class", own, b'{"frozen":true}'), (403,)),
        "the stage of another": (("PUT", f"{path}/stages/1", own, b"{}"), (404,)),
        "all answers": (("GET", f"{path}/table", own), (403,)),
        "another pupil taken away": (("DELETE", f"{path}/pupils/1", own), (403,)),
        "the room erased": (("DELETE", path, own), (403,)),
        "a token of another room": (("GET", path, foreign), (404,)),
        "the other room's teacher's": (("PUT", f"{path}/stages/class", foreign, b'{"frozen":true}'), (404,)),
        "a token of nobody": (("GET", f"{path}/events", nobody), (404,)),
        "no token": (("GET", path), (401,)),
        "a token of no form": (("GET", path, "' OR 1=1 --"), (401,)),
        "a room by no code": (("GET", "/v1/classes/..%2f..%2fetc", own), (404,)),
    }
    return {what: (one(port, *words), wanted) for what, (words, wanted) in tries.items()}


def streams(port, path, token, count):
    """Streams that are opened and not read: those that the server has let in, and the status of the others."""
    told, lines = collections.Counter(), []
    for _ in range(count):
        with contextlib.suppress(OSError):
            line = connect(port)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            line.sendall(message("GET", f"{path}/events", token))
            told[int(STATUS.match(line.recv(64))[1])] += 1
            lines.append(line)
    return told, lines


def attack(port, path, foreign, count, pipe):
    """All of it, in a process of its own; what came of it goes into the pipe."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=60, source_address=(ADDRESS, 0))
    line.request("POST", f"{path}/pupils", json.dumps({"nickname": SCRIPT}), {"Content-Type": "application/json"})
    own = json.loads(line.getresponse().read())["token"]
    began = time.monotonic()
    told = {"streams": streams(port, path, own, STREAMS + 50)}
    told["trespasses"] = trespasses(port, path, own, foreign)
    told["joins"] = joins(port, path, count)
    told["join seconds"] = time.monotonic() - began
    began = time.monotonic()
    told["guesses"] = guesses(port, count // 20)
    told["guess seconds"] = time.monotonic() - began
    told["writes"] = many(port, [message("PUT", f"{path}/stages/own", own, b'{"state":"%s"}' % (b"done", b"stuck")[i % 2]) for i in range(count // 20)])
    told["streams"] = told["streams"][0]
    pipe.send(told)


def memory(daemon):
    text = pathlib.Path(f"/proc/{daemon.process.pid}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", text)[1])


def missing(rooms):
    """How many changes were not heard of yet."""
    return sum(len(room.sent) + room.expected - len(room.pushes) for room in rooms)


async def lesson(rooms, seconds, attacker=None):
    """A lesson in every room, until `seconds` are over and the attacker, if there is one, has ended; {what: its times}."""
    for room in rooms:
        room.writes, room.board, room.pushes, room.expected, room.sent = [], [], [], 0, {}
    begun = time.monotonic()
    while not (time.monotonic() - begun > seconds and not (attacker and attacker.is_alive())):
        await asyncio.gather(*(room.lesson(min(seconds, 10)) for room in rooms))
    left, since = missing(rooms), time.monotonic()
    while left and time.monotonic() - since < STILL:
        await asyncio.sleep(0.1)
        left, before = missing(rooms), left
        since = time.monotonic() if left != before else since
    return {what: sorted(1e3 * took for room in rooms for took in getattr(room, what)) for what in ("writes", "board", "pushes")}


def figures(times):
    return ", ".join(f"{what} p50 {all_[len(all_) // 2]:.1f} ms p99 {all_[int(0.99 * (len(all_) - 1))]:.1f} ms ({len(all_)})" for what, all_ in times.items())


async def beside(daemon, options):
    rooms = [Room(number, [daemon.port]) for number in range(ROOMS)]
    await asyncio.gather(*(room.begin(PUPILS) for room in rooms))
    await rooms[0].line.ask("PUT", f"{rooms[0].path}/questions/q", rooms[0].token, {"text": "How long?", "kind": "text"})
    alone = await lesson(rooms, options.seconds)
    before = memory(daemon)
    mine, its = multiprocessing.Pipe()
    attacker = multiprocessing.Process(target=attack, args=(daemon.port, rooms[0].path, rooms[1].token, options.joins, its), daemon=True)
    attacker.start()
    during = await lesson(rooms, options.seconds, attacker)
    told, after = mine.recv(), memory(daemon)
    print(f"the others alone: {figures(alone)}\nbeside it:        {figures(during)}")
    lost = missing(rooms)
    check("every change of the others came", not lost, f"{lost} did not")
    inside = await rooms[0].line.ask("GET", rooms[0].path, rooms[0].token)
    await rooms[0].line.ask("PUT", f"{rooms[0].path}/stages/class", rooms[0].token, {"open": False})
    check("who joins when the door is shut is refused", one(daemon.port, "POST", f"{rooms[0].path}/pupils", "", b'{"nickname":"Eve"}') in (403, 429))
    for room in rooms:
        await room.line.ask("DELETE", room.path, room.token)
        for task in room.tasks:
            task.cancel()
    return told, inside["pupils"], before, after


def account(told, places, before, after, count):
    words = lambda seen: ", ".join(f"{status} {times} times" for status, times in sorted(seen.items(), key=str))  # noqa: E731
    print(f"{count} joins in {told['join seconds']:.1f} s: {words(told['joins'])}; {places} places of {PLACES} are taken\n"
          f"{count // 20} guessed codes in {told['guess seconds']:.1f} s: {words(told['guesses'])}; a code is one of {len(LETTERS) ** 5} (25 bits)\n"
          f"{count // 20} writes without a pause: {words(told['writes'])}\n{STREAMS + 50} streams that are never read: {words(told['streams'])}\n"
          f"memory of the daemon: {before >> 20} MiB before, {after >> 20} MiB after")
    for what, (status, wanted) in told["trespasses"].items():
        print(f"  {what}: {status or 'ended'}")
        check(f"{what} is refused", status in wanted, f"{status}, not {wanted}")
    let = told["joins"][201]
    check("places are bounded", places <= PLACES and let <= places, f"{let} joined, {places} places")
    check("who joins again and again is told to wait", told["joins"][429] > 0 and set(told["joins"]) <= {201, 429, "ended"}, str(told["joins"]))
    most = BURST + A_SECOND * told["guess seconds"] + 1
    check("guesses are bounded", BURST <= told["guesses"][404] <= most and set(told["guesses"]) <= {404, 429, "ended"}, str(told["guesses"]))
    check("streams are bounded", told["streams"][200] == STREAMS and set(told["streams"]) <= {200, 429}, str(told["streams"]))
    check("writes are bounded", told["writes"][429] > 0 and set(told["writes"]) <= {200, 429, "ended"}, str(told["writes"]))
    check("memory is bounded", after - before < GROWTH, f"{before} and {after}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--joins", type=int, default=100000)
    parser.add_argument("--seconds", type=float, default=20)
    options = parser.parse_args()
    with place("sqlite") as store, tempfile.TemporaryDirectory(prefix="pendulumd-hostile-") as logs:
        daemon = Daemon(TOP / options.build, store.url, "all", logs)
        try:
            account(*asyncio.run(beside(daemon, options)), options.joins)
            check("the daemon ends in order", daemon.kill(15) == 0)
        finally:
            if daemon.process.poll() is None:
                daemon.kill()
    return summary()


if __name__ == "__main__":
    sys.exit(main())
