"""A day in a school: thirty pupils, five batch clients and an attacker on one daemon, which is restarted and killed meanwhile; and
classes against classes.

usage: school.py BUILD [--seconds S] (by default 10 s; make school: 300 s)
Pupils compute, as a page does, and ask again where a connection ends before its answer begins; batch clients post jobs, wait for
them and compare their results; the attacker, at another loopback address and without a key, sends what is malformed, too large, too
deep, too long, forged or slow. It tells the times of answers, and fails when anybody but the attacker gets an error, when a job is
lost or differs from another of the same request, or when the daemon keeps descriptors. Then classes abuse what they share with
others: in a long run the table of hostile.py, in a short one what of it no machine's pace changes.

Leaves to others: single abuses and their sentences (tests/wire), kills of single processes (drill.py).
Invariant: traffic stays on loopback; what was started ends.
"""
import argparse
import http.client
import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(TOP / "tests/rules"))
import hostile  # noqa: E402
from rule import check, summary  # noqa: E402

PUPILS, BATCH, PATIENCE = 30, 5, 30.0
ARMS = {"arms": [{"name": "a", "length": 1, "mass": 1}, {"name": "b", "parent": "a", "length": 1, "mass": 1}]}


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class School:
    """The daemon, its keys, and what everybody has seen."""

    def __init__(self, build, directory):
        self.program, self.directory = str(pathlib.Path(build) / "pendulumd"), pathlib.Path(directory)
        self.port, self.over, self.lock = free_port(), threading.Event(), threading.Lock()
        self.times, self.late, self.errors, self.refused, self.jobs = [], [], [], {}, 0
        self.results, self.restarts, self.daemon = {}, 0, None

    def key(self, name, role):
        done = subprocess.run([self.program, "keys", "add", "--keys", self.directory / "keys", "--name", name, "--role", role],
                              check=True, capture_output=True, text=True)
        return next(word for word in done.stdout.split() if word.startswith("pdk_"))

    def start(self):
        with open(self.directory / "log", "ab") as log:
            self.daemon = subprocess.Popen(
                [self.program, "--listen", f"127.0.0.1:{self.port}", "--store", f"sqlite:{self.directory / 'store'}", "--allow-root", "on",
                 "--keys", self.directory / "keys", "--log", self.directory / "requests", "--drain-idle-seconds", "0.2", "--header-seconds", "2",
                 "--job-lease-seconds", "2"],
                stdout=log, stderr=log)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and self.daemon.poll() is None:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1).close()
                return
            except OSError:
                time.sleep(0.01)
        raise RuntimeError((self.directory / "log").read_text()[-2000:])

    def stop(self, how):
        self.daemon.send_signal(how)
        status = self.daemon.wait(90)
        if how == signal.SIGTERM and status:
            self.error("the daemon", f"ended with {status}")

    def error(self, who, what):
        with self.lock:
            self.errors.append(f"{who}: {what}")

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.daemon.pid}/fd"))


class Client:
    """One that behaves: it asks again where nothing was answered, as a browser does."""

    def __init__(self, school, name, role):
        self.school, self.name, self.line, self.timed = school, name, None, role == "pupil"
        self.head = {"Authorization": f"Bearer {school.key(name, role)}", "Content-Type": "application/json"}

    def ask(self, method, path, body=None, **fields):
        """Status, fields, body; the status is 0 where there was no answer in time."""
        began, met = time.monotonic(), False
        while time.monotonic() - began < PATIENCE:
            try:
                if not self.line:
                    self.line = http.client.HTTPConnection("127.0.0.1", self.school.port, timeout=PATIENCE)
                self.line.request(method, path, body and json.dumps(body), self.head | fields)
                reply = self.line.getresponse()
                data = reply.read()
                took = time.monotonic() - began
                if self.timed:  # a batch client's question may wait for a job
                    with self.school.lock:
                        (self.school.late if met else self.school.times).append(took)
                if reply.will_close:
                    self.line = None
                return reply.status, reply.headers, data
            except (OSError, http.client.HTTPException):
                self.line, met = None, True
                time.sleep(0.02)
        return 0, {}, b""

    def good(self, what, status, wanted, data):
        if status != wanted:
            self.school.error(self.name, f"{what}: {status} {data[:200]}")
        return status == wanted


def pupil(client, dice):
    """Drags the pendulum, looks at a motion, sees the modes; each request another one, so that the cache does not answer all."""
    while not client.school.over.is_set():
        start = {"theta": [round(dice.uniform(-3, 3), 2) for _ in range(2)]}
        kind = dice.randrange(4)
        if kind < 2:
            body = {"pendulum": ARMS, "initial": start, "times": {"start": 0, "stop": dice.choice((5, 10)), "count": 300}}
            status, _, data = client.ask("POST", "/v1/trajectories", body)
        elif kind == 2:
            status, _, data = client.ask("POST", "/v1/modes", {"pendulum": ARMS})
        else:
            status, _, data = client.ask("GET", "/version")
        client.good(f"request {kind}", status, 200, data)
        client.school.over.wait(dice.uniform(0.1, 0.6))


def batch(client, dice):
    """Posts a job, again with the same key if nothing was answered; waits for its end, and keeps what came out."""
    while not client.school.over.is_set():
        number = dice.randrange(6)
        body = {"pendulum": ARMS, "initial": {"theta": [0.5 + 0.1 * number, 1]}, "times": {"start": 0, "stop": 200, "count": 2000}}
        status, fields, data = client.ask("POST", "/v1/trajectories", body, Prefer="respond-async",
                                          **{"Idempotency-Key": f"{client.name}-{dice.getrandbits(60)}"})
        if not client.good("a job", status, 202, data):
            return
        place, state = fields["Location"], ""
        end = time.monotonic() + 4 * PATIENCE
        while state not in ("successful", "failed", "dismissed") and time.monotonic() < end:
            status, _, data = client.ask("GET", place + "?wait=5")
            if not client.good("a job's state", status, 200, data):
                return
            state = json.loads(data)["status"]
        if state != "successful":
            client.school.error(client.name, f"{place} is {state}: {data[:300]}")
            return
        status, _, data = client.ask("GET", place + "/results", Accept="text/csv")
        if client.good("a job's results", status, 200, data):
            with client.school.lock:
                client.school.jobs += 1
                same = client.school.results.setdefault(number, data) == data
            if not same:
                client.school.error(client.name, f"{place} differs from an earlier job of the same request")


def posted(body, path="/v1/trajectories", more=""):
    return f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n{more}Content-Length: {len(body)}\r\n\r\n{body}".encode()


ABUSES = {
    "two hosts": b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
    "smuggled": b"POST /v1/trees HTTP/1.1\r\nHost: a\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET / HTTP/1.1\r\n\r\n",
    "bare line feeds": b"GET / HTTP/1.1\nHost: a\n\n",
    "a head without end": b"GET / HTTP/1.1\r\nHost: a\r\n" + b"X: " + b"a" * 20000,
    "a body of terabytes": b"POST /v1/trees HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\nContent-Length: 9999999999999\r\n\r\n",
    "nests": posted("[" * 100000),
    "not numbers": posted('{"pendulum":{"arms":[{"length":1e999,"mass":NaN}]}}'),
    "a forged key": posted("{}", more="Authorization: Bearer pdk_aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa000000\r\n"),
    "no such place": b"GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "too many samples": posted('{"pendulum":{"arms":[{"length":1,"mass":1}]},"times":{"start":0,"stop":1,"count":999999999}}'),
}


def abuse(school, name, message):
    """Sends one message from another address; the status of the answer, 0 where the connection only ended."""
    with socket.socket() as line:
        line.settimeout(PATIENCE)
        line.bind(("127.0.0.2", 0))
        line.connect(("127.0.0.1", school.port))
        try:
            line.sendall(message)
            head = line.recv(64)
        except (ConnectionResetError, BrokenPipeError):
            head = b""
    status = int(head.split()[1]) if head.startswith(b"HTTP/1.1 ") else 0
    with school.lock:
        seen = school.refused.setdefault(name, {})
        seen[status] = seen.get(status, 0) + 1
    if 200 <= status < 300 or status == 500:
        school.error("the attacker", f"{name} got {status}")


def attacker(school, dice):
    """Every abuse in turn, and some connections that say a byte and stay."""
    slow = []
    while not school.over.is_set():
        try:
            for name, message in ABUSES.items():
                abuse(school, name, message)
                if dice.random() < 0.5:
                    slow.append(socket.create_connection(("127.0.0.1", school.port), 5, ("127.0.0.2", 0)))
                    slow[-1].send(b"G")
        except OSError:
            time.sleep(0.02)
        while len(slow) > 64:
            slow.pop(0).close()
        school.over.wait(0.05)
    for line in slow:
        line.close()


def day(school, seconds):
    """Everybody at once; meanwhile the daemon is told to end and started again, and killed."""
    clients = [Client(school, f"pupil-{i}", "pupil") for i in range(PUPILS)] + [Client(school, f"batch-{i}", "batch") for i in range(BATCH)]
    everybody = [threading.Thread(target=pupil if i < PUPILS else batch, args=(client, random.Random(i))) for i, client in enumerate(clients)]
    everybody.append(threading.Thread(target=attacker, args=(school, random.Random(1000))))
    school.start()
    time.sleep(0.5)
    idle = school.descriptors()
    for one in everybody:
        one.start()
    pause = min(seconds / 4, 60)
    end = time.monotonic() + seconds - pause
    while time.monotonic() < end:
        time.sleep(pause)
        school.stop(signal.SIGKILL if school.restarts % 2 else signal.SIGTERM)
        school.start()
        school.restarts += 1
    time.sleep(pause)
    school.over.set()
    for one in everybody:
        one.join()
    for client in clients:
        if client.line:
            client.line.close()
    end = time.monotonic() + PATIENCE
    while school.descriptors() > idle and time.monotonic() < end:
        time.sleep(0.1)
    check("descriptors at the end", school.descriptors() <= idle, f"{school.descriptors()}, at the start {idle}")
    school.stop(signal.SIGTERM)


def tell(school):
    times = sorted(school.times)
    share = lambda part: 1e3 * times[min(len(times) - 1, int(part * len(times)))]  # noqa: E731
    print(f"{PUPILS} pupils, {BATCH} batch clients: {len(times)} answers to pupils, half within {share(0.5):.1f} ms, p99 {share(0.99):.1f} ms, "
          f"slowest {1e3 * times[-1]:.0f} ms; {len(school.late)} more met one of {school.restarts} restarts, the slowest took "
          f"{1e3 * max(school.late, default=0):.0f} ms; {school.jobs} jobs, {len(school.results)} different")
    print("the attacker: " + "; ".join(f"{name} " + ", ".join(f"{status or 'ended'} {count} times" for status, count in sorted(seen.items()))
                                       for name, seen in school.refused.items()))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=10)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="pendulumd-school-") as directory:
        school = School(options.build, directory)
        try:
            day(school, options.seconds)
        finally:
            if school.daemon and school.daemon.poll() is None:
                school.daemon.kill()
                school.daemon.wait()
        tell(school)
    check("nobody but the attacker got an error", not school.errors, "\n  ".join(school.errors[:10]))
    check("every client was answered", len(school.times) > PUPILS and school.jobs >= BATCH, f"{len(school.times)} and {school.jobs}")
    check("every abuse was refused", set(school.refused) == set(ABUSES), str(school.refused))
    check("the daemon was restarted", school.restarts >= 2, str(school.restarts))
    hostile.table(options.build, options.seconds / 30) if options.seconds >= 60 else hostile.short(options.build)
    return summary()


if __name__ == "__main__":
    sys.exit(main())
