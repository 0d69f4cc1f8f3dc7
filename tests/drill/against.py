"""Classes against classes: one abuses the server in each way that is known, and another works beside it.

A teacher, who has an address of her own, shows one thing after the other, and measures how long it takes to a pupil's stream, how
long a small request takes, and how long a wait for a job's end; first alone, then beside each abuse. The memory of the daemon
is read meanwhile.

Leaves to others: who begins it and when (school.py), what single abuses are answered (hostile.py, tests/wire).
Invariant: traffic stays on loopback; what was started ends.
"""
import contextlib
import http.client
import json
import multiprocessing
import pathlib
import random
import re
import socket
import tempfile
import threading
import time

from house import Daemon
from places import place

HELD = 256 << 20  # bytes: max-held-bytes of the daemon
MOST = HELD * 6 // 5 + (64 << 20)  # bytes that the process may have
FACTOR, LEAST = 2.0, 0.1  # how much later things may be beside an abuse: so many times alone, or so many s
PAUSE, PATIENCE = 0.02, 15.0  # s between two things that are shown; that one may take
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
TEACHER, PUPIL = "127.0.1.1", "127.0.1.2"
DOUBLE = {"pendulum": {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}, "initial": {"theta": [1, 0]}}


def message(method, path, token="", body=b"", kind="application/json"):
    fields = f"Class-Token: {token}\r\n" if token else ""
    fields += f"Content-Type: {kind}\r\nContent-Length: {len(body)}\r\n" if body else ""
    return f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n".encode() + body


def connect(port, address, seconds=60.0):
    return socket.create_connection(("127.0.0.1", port), seconds, (address, 0))


class Line:
    """A connection that is kept."""

    def __init__(self, port, address, token=""):
        self.http = http.client.HTTPConnection("127.0.0.1", port, timeout=60, source_address=(address, 0))
        self.fields = {"Content-Type": "application/json"} | ({"Class-Token": token} if token else {})

    def ask(self, method, path, body=None, **more):
        self.http.request(method, path, None if body is None else json.dumps(body), self.fields | more)
        reply = self.http.getresponse()
        data = reply.read()
        return reply.status, json.loads(data) if data[:1] in (b"{", b"[") else data


def joined(port, path, address, nickname):
    """The token of a new pupil; who has to wait waits."""
    while True:
        status, told = Line(port, address).ask("POST", f"{path}/pupils", {"nickname": nickname})
        if status == 201:
            return told["token"]
        time.sleep(0.2)


class Full:
    """A room that is as full as may be: worksheets, and what pupils have handed in."""

    def __init__(self, port, address="127.0.2.1", pupils=60, sheets=20):
        _, room = Line(port, address).ask("POST", "/v1/classes", {"hours": 1})
        self.path, self.token = f"/v1/classes/{room['code']}", room["token"]
        line = Line(port, address, self.token)
        sheet = {"title": "x" * 200, "steps": [{"id": f"s{i}", "text": "y" * 1200, "question": {"kind": "number", "text": "?"}} for i in range(40)]}
        for i in range(sheets):
            line.ask("PUT", f"{self.path}/worksheets/w{i}", sheet)
        answers = {"answers": [{"step": f"s{i}", "value": i} for i in range(40)]}
        self.pupils = []
        for i in range(pupils):
            self.pupils.append(joined(port, self.path, f"127.0.3.{1 + i // 8}", "\U0001f600" * 32))
            line = Line(port, address, self.pupils[-1])
            for k in range(sheets):
                line.ask("PUT", f"{self.path}/handins/w{k}", answers)


# --- abuses: each takes the port, an address, a full room, and an event that ends it ---

def streams(port, address, room, over, count=48, path="events"):
    """Streams that are read at full speed, from the beginning again at their end."""
    lines, begun = {}, 0
    while not over.is_set():
        while len(lines) < count:
            line = connect(port, address)
            line.sendall(message("GET", f"{room.path}/{path}", room.token))
            lines[line], begun = [0, time.monotonic()], begun + 1
        for line, state in list(lines.items()):
            line.settimeout(0.002)
            got = b""
            with contextlib.suppress(OSError):
                got = line.recv(1 << 18)
            state[0] += len(got)
            if got:
                state[1] = time.monotonic()
            elif time.monotonic() - state[1] > 0.1:
                line.close()
                del lines[line]


def unread(port, address, room, over, path="table", count=64):
    """Reports that are asked for and not read."""
    lines = []
    while not over.is_set():
        if len(lines) < count:
            line = connect(port, address)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            line.sendall(message("GET", f"{room.path}/{path}", room.token))
            lines.append(line)
        else:
            over.wait(0.05)


def left(port, address, room, over, path="table"):
    """The same, closed at once."""
    while not over.is_set():
        with contextlib.suppress(OSError), connect(port, address) as line:
            line.sendall(message("GET", f"{room.path}/{path}", room.token))


def asked(port, address, over, make, at_once=16):
    """Requests without a pause, some on each connection before an answer is read."""
    line = None
    while not over.is_set():
        try:
            line = line or connect(port, address, 5)
            line.sendall(b"".join(make() for _ in range(at_once)))
            got = 0
            while got < at_once:
                data = line.recv(1 << 18)
                if not data:
                    raise ConnectionError
                got += data.count(b"HTTP/1.1 ")
        except OSError:
            line = None


def code():
    return "".join(random.choice(LETTERS) for _ in range(6))


def guesses(port, _address, _room, over):
    asked(port, PUPIL, over, lambda: message("POST", f"/v1/classes/{code()}/pupils", "", b'{"nickname":"Eve"}'))


def rooms(port, _address, _room, over):
    """All rooms, from four addresses."""
    makers = [threading.Thread(target=asked, args=(port, f"127.0.4.{i}", over, lambda: message("POST", "/v1/classes", "", b'{"hours":720}')))
              for i in range(1, 5)]
    for maker in makers:
        maker.start()
    for maker in makers:
        maker.join()


def joins(port, address, room, over):
    asked(port, address, over, lambda: message("POST", f"{room.path}/pupils", "", b'{"nickname":"Anna"}'))


def silent(port, _address, _room, over, count=1024):
    """Connections that say nothing, from four addresses, each opened again when it is closed."""
    lines, i = [], 0
    while not over.is_set():
        i += 1
        with contextlib.suppress(OSError):
            line = connect(port, f"127.0.5.{1 + i % 4}", 0.05)
            line.setblocking(False)
            lines.append(line)
        if len(lines) >= 4 * count or not i % 512:
            kept = []
            for line in lines:
                try:
                    gone = line.recv(64, socket.MSG_PEEK) == b""
                except OSError as error:
                    gone = not isinstance(error, BlockingIOError)
                if gone:
                    line.close()
                else:
                    kept.append(line)
            lines = kept
            over.wait(0.01 if len(lines) < 4 * count else 0.2)


def forms(port, address, _room, over):
    """Forms of nearly 8 MB for a fit."""
    table = b"t,x\n" + b"0.123456,0.654321\n" * 400000
    head = b'--b\r\nContent-Disposition: form-data; name="request"\r\n\r\n{"pendulum":{"length":[1],"mass":[1]},"fit":["length"]}\r\n'
    body = head + b'--b\r\nContent-Disposition: form-data; name="csv"; filename="a.csv"\r\n\r\n' + table + b"\r\n--b--\r\n"
    one = message("POST", "/v1/fits", "", body, "multipart/form-data; boundary=b")
    many = [threading.Thread(target=asked, args=(port, address, over, lambda: one, 1)) for _ in range(8)]
    for thread in many:
        thread.start()
    for thread in many:
        thread.join()


def whole(port, address, room, over):
    """The whole room, again and again, on many connections."""
    many = [threading.Thread(target=asked, args=(port, address, over, lambda: message("GET", room.path, room.token), 4)) for _ in range(16)]
    for thread in many:
        thread.start()
    for thread in many:
        thread.join()


def histograms(port, address, room, over):
    streams(port, address, room, over, 200, "histograms/w1")


def writes(port, address, room, over):
    """What all pupils of a room write and as many streams are told."""
    listener = threading.Thread(target=streams, args=(port, address, room, over, 100))
    listener.start()
    sheet = lambda: json.dumps({"scene": {"request": DOUBLE | {"x": random.random()}}, "state": "done"}).encode()  # noqa: E731
    many = iter(lambda: random.choice(room.pupils), None)
    asked(port, address, over, lambda: message("PUT", f"{room.path}/stages/own", next(many), sheet()))
    listener.join()


def waits(port, address, _room, over):
    """Waits for jobs that do not end, as many as may be."""
    body = DOUBLE | {"times": {"start": 0, "stop": 1e6, "count": 3}}
    _, job = Line(port, address).ask("POST", "/v1/trajectories", body, Prefer="respond-async")
    lines = []
    while not over.is_set():
        line = connect(port, address)
        line.sendall(message("GET", f"/v1/jobs/{job['id']}?wait=30"))
        lines.append(line)
        if len(lines) > 300:
            lines.pop(0).close()


def storm(port, address, room, over):
    """Streams that are opened and closed at once."""
    left(port, address, room, over, "events")


ABUSES = {
    "48 streams of an own full room": streams,
    "64 tables that are not read": unread,
    "tables closed at once": left,
    "wrong codes from the same address": guesses,
    "all rooms from four addresses": rooms,
    "one joins 400 times": joins,
    "silent connections": silent,
    "forms of 8 MB": forms,
    "the whole room, without a pause": whole,
    "200 histograms": histograms,
    "all pupils write, 100 streams hear": writes,
    "300 waits for a job": waits,
    "streams closed at once": storm,
}


def abuse(name, port, address, room, over):
    """In a process of its own; what the server does to it is no fault."""
    import resource
    resource.setrlimit(resource.RLIMIT_NOFILE, (8192, 8192))
    while not over.is_set():
        with contextlib.suppress(OSError, http.client.HTTPException, KeyError):
            ABUSES[name](port, address, room, over)


# --- who works beside it ---

class Work:
    """A class at work: what it showed, and how long all took."""

    def __init__(self, port):
        self.port, self.seen, self.number = port, threading.Condition(), 0
        _, room = Line(port, TEACHER).ask("POST", "/v1/classes", {"hours": 1})
        self.path, self.heard = f"/v1/classes/{room['code']}", 0
        self.teacher, self.other = Line(port, TEACHER, room["token"]), Line(port, TEACHER, room["token"])
        self.pupil = joined(port, self.path, PUPIL, "Ben")
        threading.Thread(target=self.hear, daemon=True).start()

    def hear(self):
        with connect(self.port, PUPIL, None) as line:
            line.sendall(message("GET", f"{self.path}/events", self.pupil))
            for text in line.makefile("rb"):
                found = re.match(rb'data:\{.*"number":(\d+)', text)
                if found:
                    with self.seen:
                        self.heard = int(found[1])
                        self.seen.notify()

    def shows(self):
        """Seconds until the pupil hears of it; PATIENCE if it does not."""
        began, self.number = time.monotonic(), self.number + 1
        self.teacher.ask("PUT", f"{self.path}/stages/class", {"frozen": bool(self.number % 2), "release": {"number": self.number}})
        with self.seen:
            self.seen.wait_for(lambda: self.heard == self.number, PATIENCE)
        return time.monotonic() - began

    def asks(self):
        began = time.monotonic()
        self.other.ask("GET", f"{self.path}?since={self.number}")
        return time.monotonic() - began

    def waits(self):
        began = time.monotonic()
        status, job = self.other.ask("POST", "/v1/trajectories", DOUBLE | {"times": {"start": 0, "stop": 1, "count": 3}}, Prefer="respond-async")
        if status == 202:
            self.other.ask("GET", f"/v1/jobs/{job['id']}?wait=15")
        return time.monotonic() - began

    def measure(self, seconds, pid):
        """{what: (p50, p99)} and the most memory."""
        times, most, end = {"event": [], "request": [], "wait": []}, 0, time.monotonic() + seconds
        while time.monotonic() < end:
            times["event"].append(self.shows())
            times["request"].append(self.asks())
            if len(times["event"]) % 5 == 1:
                times["wait"].append(self.waits())
            most = max(most, memory(pid))
            time.sleep(PAUSE)
        return {what: (sorted(all_)[len(all_) // 2], sorted(all_)[int(0.99 * (len(all_) - 1))]) for what, all_ in times.items()}, most


def memory(pid):
    text = pathlib.Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", text)[1])


def table(build, seconds, check, only=""):
    """All abuses, each for so many seconds; `check` is told what is not as it should be."""
    options = ("--max-held-bytes", str(HELD), "--workers", "2", "--max-connections", "4096")
    with place("sqlite") as store, tempfile.TemporaryDirectory(prefix="pendulumd-against-") as logs:
        daemon = Daemon(build, store.url, "all", logs, options)
        try:
            room, work = Full(daemon.port), Work(daemon.port)
            pid = daemon.process.pid
            print(f"{'':36}{'event p50, p99':>20}{'request':>18}{'wait':>18}  memory, MB")
            for name in ABUSES:
                if only not in name:
                    continue
                over = multiprocessing.Event()
                alone, _ = work.measure(seconds, pid)
                other = multiprocessing.Process(target=abuse, args=(name, daemon.port, "127.0.6.1", room, over), daemon=True)
                other.start()
                beside, most = work.measure(seconds, pid)
                over.set()
                other.join(20)
                if other.is_alive():
                    other.kill()
                for who, found in ((name, beside), ("  alone", alone)):
                    print(f"{who:36}" + "".join(f"{1e3 * p50:9.1f}{1e3 * p99:9.1f}" for p50, p99 in found.values()) + (f"{most >> 20:9}" if who == name else ""), flush=True)
                for what, (_, p99) in beside.items():
                    check(f"{what} beside: {name}", p99 <= max(FACTOR * alone[what][1], LEAST), f"p99 {1e3 * p99:.0f} ms, alone {1e3 * alone[what][1]:.0f} ms")
                check(f"memory beside: {name}", most <= MOST, f"{most >> 20} MB, not {MOST >> 20}")
        finally:
            if daemon.process.poll() is None:
                daemon.kill(15)


if __name__ == "__main__":
    import sys
    sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tests/rules"))
    from rule import check, summary
    table(pathlib.Path(sys.argv[1]).resolve(), float(sys.argv[2]), check, sys.argv[3] if len(sys.argv) > 3 else "")
    sys.exit(summary())
