"""Daemons on one store that are killed, stopped and started, what they were asked, and the account in the end.

Leaves to others: what goes wrong and when (faults.py), the stores (places.py). Invariant: every job that was answered
202 stands in the account until it was seen to end as it should, with the right bits.
"""
import http.client
import itertools
import json
import os
import pathlib
import signal
import struct
import subprocess
import time

from places import die_with_parent

LEASE = 2  # s: short, but a machine that is busy otherwise is not to make workers seem silent
PART = "0.03"  # s of computation in a part
DOUBLE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
FOUR = '"pendulum":{"L":[2,1.5,0.75,1.25],"m":[1,1,1,0.1],"S":[[1,0,0,0],[1,1,0,0],[1,1,1,0],[1,1,0,1]]}'
OCTETS = "application/octet-stream"
PATIENCE = 300  # s that a job may take, whatever happens to it


def flips(columns, rows=60, duration=20):
    return (f'{{{DOUBLE},"duration":{duration},"grid":[{{"vary":"theta","arm":1,"start":-3,"stop":3,"count":{rows}}},'
            f'{{"vary":"theta","arm":2,"start":-3,"stop":3,"count":{columns}}}],"observables":["first_flip","final"]}}')


def walk(stop, count, more=""):
    return f'{{{FOUR},"times":{{"start":0,"stop":{stop},"count":{count}}}{more}}}'


# what is asked for: many parts, and a single one
JOBS = {"map": ("/v1/ensembles", flips(100)), "walk": ("/v1/trajectories", walk(300, 2001))}
# methods and operations that carry other numbers from one part to the next
VARIOUS = {method: ("/v1/trajectories", walk(stop, 1001, f',"{field}":"{method}"')) for field, method, stop in (
    ("method", "rk8pd", 600), ("method", "ode23", 600), ("method", "radau", 200), ("method", "symplectic", 400), ("precision", "extended", 200))} | {
    "derivatives": ("/v1/trajectories", walk(200, 501, ',"derivatives":[{"vary":"length","arm":1}]')),
    "random": ("/v1/ensembles", f'{{{DOUBLE},"duration":20,"random":{{"count":4000,"seed":7,"draw":[{{"vary":"theta","arm":1,"distribution":"normal",'
               '"mean":0,"deviation":1}]},"observables":["final"]}'),
    "exponents": ("/v1/lyapunov", f'{{{DOUBLE},"initial":{{"theta":[2,2]}},"duration":4000}}'),
    "sections": ("/v1/sections", f'{{{DOUBLE},"initial":{{"theta":[2,2]}},"duration":4000,"section":{{"arm":1,"theta":0}}}}')}
# what is not meant to end, or not meant to fit
OTHERS = {"long": ("/v1/trajectories", walk(1e6, 3)), "big": ("/v1/ensembles", flips(4000)), "wide": ("/v1/trajectories", walk(5, 20001))}


class Daemon:
    """A pendulumd that listens on a free port."""

    def __init__(self, build, url, role, directory, options=(), environment=None):
        self.role, self.stopped = role, False
        self.log = pathlib.Path(directory, f"{role}-{time.monotonic_ns()}.log")
        command = [pathlib.Path(build, "pendulumd"), "--listen", "127.0.0.1:0", "--store", url, "--role", role, "--cache-bytes", "0",
                   "--workers", "1", "--access-log", "off", *options]
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
                                            env={"PENDULUMD_ALLOW_ROOT": "on"} | os.environ | (environment or {}), preexec_fn=die_with_parent(signal.SIGKILL))
        end = time.monotonic() + PATIENCE
        while "listening on" not in (text := self.log.read_text()):
            if self.process.poll() is not None or time.monotonic() > end:
                self.kill()
                raise RuntimeError(f"pendulumd does not start: {text}")
            time.sleep(0.005)
        self.port = int(text.split("listening on", 1)[1].split()[0].rsplit(":", 1)[1])

    def ask(self, method, path, body=None, headers=None, seconds=120):
        """Status, header fields, bytes; OSError or HTTPException where there was no answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=seconds)
        try:
            connection.request(method, path, body, ({"Content-Type": "application/json"} if body else {}) | (headers or {}))
            reply = connection.getresponse()
            return reply.status, reply.headers, reply.read()
        finally:
            connection.close()

    def metric(self, name):
        _, _, text = self.ask("GET", "/metrics")
        return next((float(line.rsplit(" ", 1)[1]) for line in text.decode().splitlines() if line.startswith(f"{name} ")), 0.0)

    def kill(self, number=signal.SIGKILL):
        self.process.send_signal(number)
        return self.process.wait(PATIENCE)


class House:
    """The daemons on one store, and the account of what they were asked."""

    def __init__(self, build, place, random, directory, right):
        self.build, self.place, self.random, self.directory, self.right = build, place, random, str(directory), right
        self.daemons, self.turn, self.keys = [], itertools.count(), itertools.count()
        self.accepted, self.notes = {}, {}
        self.lost, self.wrong = [], []
        self.url, self.part = {}, PART  # url: of roles that reach the store another way
        self.folder, self.more = None, ()  # of results as files, and the option that names it

    # --- daemons

    def start(self, role, *options, environment=None):
        options = ("--job-part-seconds", self.part, "--job-lease-seconds", str(LEASE), *self.more, *options)
        self.daemons.append(Daemon(self.build, self.url.get(role, self.place.url), role, self.directory, options, environment))
        return self.daemons[-1]

    def pick(self, role):
        return self.random.choice([daemon for daemon in self.daemons if daemon.role == role])

    def kill(self, daemon):
        """Kills it, and counts the parts that it held."""
        daemon.kill()
        self.daemons.remove(daemon)
        self.note("held", self.held(daemon))

    def held(self, daemon):
        return self.place.rows(f"SELECT COUNT(*) FROM parts WHERE state = 1 AND worker LIKE '%:{daemon.process.pid}:%'")[0][0]

    def close(self):
        for daemon in self.daemons:
            if daemon.stopped:
                daemon.process.send_signal(signal.SIGCONT)
            if daemon.process.poll() is None and daemon.kill(signal.SIGTERM):
                self.wrong.append(f"a daemon ended with {daemon.process.returncode}")
        self.daemons = []

    def nap(self, least, most):
        time.sleep(self.random.uniform(least, most))

    def note(self, what, count=1):
        self.notes[what] = self.notes.get(what, 0) + count

    def all_here(self):
        """A daemon that nobody killed and that is gone is what no fault may lead to."""
        for daemon in [daemon for daemon in self.daemons if daemon.process.poll() is not None]:
            self.wrong.append(f"a {daemon.role} has ended by itself with {daemon.process.returncode}: {daemon.log.read_text()[-300:]}")
            self.daemons.remove(daemon)
            self.start(daemon.role)

    # --- what is asked

    def ask(self, method, path, body=None, headers=None, patience=PATIENCE):
        """As Daemon.ask, of whichever process answers; who is away, or asks to come again, is asked again."""
        end = time.monotonic() + patience
        while True:
            apis = [daemon for daemon in self.daemons if daemon.role != "worker"]
            try:
                if not apis:
                    raise ConnectionError("nobody is there")
                answer = apis[next(self.turn) % len(apis)].ask(method, path, body, headers)
                if answer[0] != 503 or time.monotonic() > end:
                    return answer
            except (OSError, http.client.HTTPException):
                if time.monotonic() > end:
                    raise
            time.sleep(0.02)

    def post(self, kind, key=None, patience=PATIENCE):
        """Asks for a job of that kind, and puts it into the account if it is accepted; the answer."""
        path, body = (JOBS | VARIOUS | OTHERS)[kind]
        headers = {"Prefer": "respond-async", "Idempotency-Key": key or f"key-{next(self.keys)}"}
        answer = self.ask("POST", path, body, headers, patience)
        if answer[0] == 202:
            self.accepted[answer[1]["Location"].rsplit("/", 1)[1]] = "successful"
        return answer

    def submit(self, kind, key=None):
        """A job of that kind: its id, and the kind."""
        status, fields, text = self.post(kind, key)
        if status != 202:
            raise RuntimeError(f"a job was answered {status}: {text[:300]}")
        return fields["Location"].rsplit("/", 1)[1], kind

    def look(self, job):
        """A job as it is described; {} where it is not known."""
        status, _, text = self.ask("GET", f"/v1/jobs/{job}")
        return json.loads(text) if status == 200 else {}

    def wait(self, job, *words):
        """Waits until a job is in one of these states; its description."""
        end = time.monotonic() + PATIENCE
        while (view := self.look(job)).get("status") not in words and view and time.monotonic() < end:
            if view["status"] not in ("accepted", "running"):
                break
            self.all_here()
            time.sleep(0.01)
        return view

    def finish(self, jobs):
        """Each has to end well, with the bits of an undisturbed answer."""
        for job, kind in jobs:
            view = self.wait(job, "successful")
            if view.get("status") != "successful":
                self.lost.append(f"{job} is {view.get('status', 'gone')}: {view.get('message')}")
                continue
            status, _, data = self.ask("GET", f"/v1/jobs/{job}/results", headers={"Accept": OCTETS})
            if status != 200 or data != self.right[kind]:
                self.wrong.append(f"{job}, {kind}: status {status}, {len(data)} bytes, {len(self.right[kind])} undisturbed")

    # --- the account

    def settle(self):
        """Waits for what a sweep does later: results of dismissed jobs go, and their sums with them."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and self.place.rows("SELECT COUNT(*) FROM removals WHERE job <> '.'")[0][0]:
            time.sleep(0.05)

    def account(self):
        """What the store says itself: nothing lost, nothing done twice, sums that agree. Fills lost and wrong."""
        rows = self.place.rows
        jobs = {row[0]: row[1:] for row in rows("SELECT id, state, parts, done, bytes FROM jobs")}
        words = ("accepted", "running", "successful", "failed", "dismissed")
        for job, word in self.accepted.items():
            state, parts, done, _ = jobs.get(job, (-1, 0, 0, 0))
            if state < 0 or words[state] != word or (word == "successful" and parts != done):
                self.lost.append(f"{job} should be {word}: state {state}, {done} of {parts} parts")
        twice = [f"part {row[1]} of {row[0]} was kept {row[2]} times" for row in
                 rows("SELECT job, number, COUNT(*) FROM drill_kept GROUP BY job, number HAVING COUNT(*) > 1")]
        twice += [f"{job} was made and nobody was told" for job in jobs if job not in self.accepted]
        for what, command in SUMS[bool(self.folder):]:
            self.wrong += [f"{what}: {row}" for row in rows(command)]
        return len(self.accepted), len(self.lost), len(twice), len(self.wrong), self.lost + twice + self.wrong


KEPT = "(SELECT COALESCE(SUM(LENGTH(data)), 0) FROM results WHERE job = jobs.id)"
LATE = "+ COALESCE((SELECT SUM(changes.{0}) FROM changes WHERE changes.name = clients.name), 0)"  # not in the client's row yet
SUMS = (
    ("bytes of a successful job", f"SELECT id, bytes, {KEPT} FROM jobs WHERE state = 2 AND bytes <> {KEPT}"),
    ("parts of a successful job", "SELECT id FROM jobs WHERE state = 2 AND parts <> (SELECT COUNT(*) FROM drill_kept WHERE job = id)"),
    ("parts that a job has done", "SELECT id, done FROM jobs WHERE state < 3 AND done <> (SELECT COUNT(*) FROM parts WHERE job = id AND state = 2)"),
    ("chunks of a part", "SELECT job, part, COUNT(*) FROM results GROUP BY job, part HAVING MIN(chunk) <> 0 OR MAX(chunk) <> COUNT(*) - 1"),
    ("open jobs of a client", f"SELECT name, jobs FROM clients WHERE jobs {LATE.format('jobs')} <> (SELECT COUNT(*) FROM jobs WHERE client = name AND state < 2)"),
    ("jobs of a client that a worker can take", f"SELECT name, ready FROM clients WHERE ready {LATE.format('ready')} <> (SELECT COUNT(*) FROM jobs WHERE client = name AND ready = 1)"),
    ("bytes of a client", f"SELECT name, bytes FROM clients WHERE bytes {LATE.format('bytes')} <> (SELECT COALESCE(SUM(bytes + held), 0) FROM jobs WHERE client = name)"),
    ("requests of jobs without success", "SELECT id FROM jobs WHERE state >= 3 AND LENGTH(request) > 0"),
    ("the sum of bytes", "SELECT 1 WHERE (SELECT SUM(bytes) FROM totals) <> (SELECT COALESCE(SUM(bytes + held), 0) FROM jobs)"),
    ("the sum of parts that wait", "SELECT 1 WHERE (SELECT SUM(waiting) FROM totals) <> (SELECT COALESCE(SUM(CASE WHEN ready = 0 THEN 0 "
                                   "WHEN chained = 1 THEN 1 ELSE waiting + parts - begun END), 0) FROM jobs)"),
    *((f"the number of {word} jobs", f"SELECT 1 WHERE (SELECT SUM({word}) FROM totals) <> (SELECT COUNT(*) FROM jobs WHERE state = {state})")
      for state, word in enumerate(("accepted", "running", "successful", "failed", "dismissed"))),
    ("leases of ended jobs", "SELECT job, number FROM parts JOIN jobs ON job = id WHERE parts.state = 1 AND jobs.state >= 2"),
    ("parts and results of no job", "SELECT job FROM parts WHERE job NOT IN (SELECT id FROM jobs) UNION SELECT job FROM results WHERE job NOT IN (SELECT id FROM jobs)"),
)


def undisturbed(build, directory, kinds=None):
    """The bits that each kind of job should answer."""
    daemon = Daemon(build, "none", "all", directory)
    try:
        right = {}
        for kind, (path, body) in (kinds or JOBS).items():
            status, _, data = daemon.ask("POST", path, body, {"Accept": OCTETS}, 60)
            if status != 200 or not any(value for value, in struct.iter_unpack("<d", data)):
                raise RuntimeError(f"{kind} was answered {status}: {data[:300]}")
            right[kind] = data
        return right
    finally:
        daemon.kill(signal.SIGTERM)
