"""Tests a rolling restart: two api and two worker processes on PostgreSQL behind docker/nginx.conf are stopped
and started again, one after the other and at other addresses, while clients send requests; none of ten thousand may
fail. The same at fixed addresses, behind docker/nginx.upstream.conf.

usage: restart.py BUILD
Leaves to others: what nginx refuses (nginx.py), processes that are killed (tests/drill).
Invariant: every status except 200 and 202 is an error, and so is every connection that ends before its answer; the
client never repeats a request.
"""
import collections
import http.client
import itertools
import json
import pathlib
import signal
import sys
import tempfile
import threading
import time

from names import Names
from rule import check, shipped_nginx, skip, summary
from house import DOUBLE, FOUR, Daemon
from places import place, postgres_programs
from servers import free_port, nginx, tool

BUILD = pathlib.Path(sys.argv[1]).resolve()
ENOUGH = 10000  # requests
ROUNDS = 2      # restarts of every process, at least
FORGOTTEN = 2   # s for which nginx remembers addresses; not twice within it is every process restarted
PATIENCE = 300  # s for one answer
ROUND_OF_ONE = 15  # requests of a client from one address: nginx counts the requests of each
JSON = {"Content-Type": "application/json"}


def short(number):
    return "POST", "/v1/trajectories", f'{{{DOUBLE},"times":{{"start":0,"stop":{1 + number % 9973 / 1e4},"count":50}}}}', JSON


def long(number):
    """A large share of a second of computation; an answer of few bytes that comes at its end."""
    return "POST", "/v1/trajectories", f'{{{FOUR},"times":{{"start":0,"stop":{3000 + number},"count":3}}}}', JSON


def job(number):
    return ("POST", "/v1/trajectories", f'{{{FOUR},"times":{{"start":0,"stop":{5 + number / 1e4},"count":20}}}}',
            JSON | {"Prefer": "respond-async"})


SHORT = (short, lambda _: ("GET", "/v1/presets", None, {}), lambda _: ("POST", "/v1/trees", f"{{{DOUBLE}}}", JSON),
         lambda _: ("GET", "/healthz", None, {}), short)
LONG = (long,)
JOBS = (job, short)


class Load:
    """Clients that ask through nginx until they are told to stop, and what came of it."""

    def __init__(self, port):
        self.port, self.stop, self.lock = port, threading.Event(), threading.Lock()
        self.numbers, self.count, self.errors, self.jobs = itertools.count(), collections.Counter(), [], []
        self.longest = 0.0

    def client(self, own, kinds, pause):
        connection = None
        for turn in itertools.count():
            if self.stop.is_set():
                return
            kind = kinds[turn % len(kinds)]
            if turn % ROUND_OF_ONE == 0 or not connection:
                source = f"127.0.{own}.{1 + turn // ROUND_OF_ONE % 250}"
                connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE, source_address=(source, 0))
            request = kind(next(self.numbers))
            begin = time.monotonic()
            try:
                connection.request(*request)
                reply = connection.getresponse()
                answer = reply.status, reply.read()
            except (OSError, http.client.HTTPException) as error:
                answer = 0, repr(error).encode()
            if answer[0] not in (200, 202):
                connection.close()
                connection = None
            self.enter(request, answer, time.monotonic() - begin)
            time.sleep(pause)

    def enter(self, request, answer, seconds):
        status, data = answer
        with self.lock:
            self.count[status] += 1
            self.longest = max(self.longest, seconds)
            if status == 202:
                self.jobs.append(json.loads(data)["id"])
            elif status != 200:
                self.errors.append(f"{request[0]} {request[1]}: {status} {data[:160].decode(errors='replace')}")

    def begin(self):
        kinds = [(SHORT, 0)] * 10 + [(LONG, 0.05)] * 3 + [(JOBS, 0.1)]
        self.threads = [threading.Thread(target=self.client, args=(1 + own, *how), daemon=True) for own, how in enumerate(kinds)]
        for thread in self.threads:
            thread.start()

    def alive(self):
        return any(thread.is_alive() for thread in self.threads)

    def total(self):
        with self.lock:
            return sum(self.count.values())

    def end(self):
        self.stop.set()
        for thread in self.threads:
            thread.join(PATIENCE)


class Fleet:
    """The processes on one store, and the name under which nginx finds those that answer."""

    def __init__(self, url, directory):
        self.url, self.directory, self.port = url, directory, free_port()
        self.hosts, self.names, self.daemons = itertools.count(2), Names(), []

    def start(self, role, host=None):
        host = host or f"127.0.0.{next(self.hosts)}"
        daemon = Daemon(BUILD, self.url, role, self.directory, ("--listen", f"{host}:{self.port}", "--trusted-proxy", "127.0.0.1/32"))
        daemon.host = host
        self.daemons.append(daemon)
        if role == "api":
            self.names.addresses.append(host)

    def end(self, daemon):
        """A container's name is gone once its process has ended."""
        status = daemon.kill(signal.SIGTERM)
        self.daemons.remove(daemon)
        if daemon.role == "api":
            self.names.addresses.remove(daemon.host)
        return status

    def close(self):
        for daemon in list(self.daemons):
            if daemon.process.poll() is None:
                self.end(daemon)
        self.names.close()


def roll(load, fleet, fixed):
    """Each in its turn is told to end, ends with 0, and is started again. The next is told as soon as the new one listens, when
    nginx still knows the addresses of before: of some requests every address that it knows is gone."""
    for old in list(fleet.daemons):
        begin = time.monotonic()
        status = fleet.end(old)
        check("a process that is told to end ends with 0", status == 0, f"{old.role}: {status} {old.log.read_text()[-300:]}")
        print(f"  {old.role} drained in {time.monotonic() - begin:.1f} s")
        fleet.start(old.role, old.host if fixed else None)


def jobs_end(load, front):
    """What was accepted during the restarts is computed."""
    left, wrong, end = list(load.jobs), [], time.monotonic() + PATIENCE
    while left and not wrong and time.monotonic() < end:
        views = [json.loads(front.ask(path=f"/v1/jobs/{one}")[2]) for one in left]
        left = [view["id"] for view in views if view.get("status") in ("accepted", "running")]
        wrong = [view for view in views if view.get("status") not in ("accepted", "running", "successful")]
        time.sleep(0.1)
    check(f"all of {len(load.jobs)} jobs end well", load.jobs and not left and not wrong, f"{len(left)} have not ended; {wrong[:1]}")


def rolling(fixed, enough):
    """Restarts behind a name whose addresses change, or behind the block of fixed addresses that is shipped."""
    with tempfile.TemporaryDirectory(prefix="pendulumd-restart-") as directory, place("postgres") as store:
        fleet = Fleet(store.url, directory)
        try:
            for role in ("api", "api", "worker", "worker"):
                fleet.start(role)
            api = [f"{daemon.host}:{fleet.port}" for daemon in fleet.daemons if daemon.role == "api"]
            with nginx(shipped_nginx(api) if fixed else shipped_nginx([fleet.port], fleet.names)) as front:
                load = Load(front.port)
                load.begin()
                rounds = 0
                while rounds < ROUNDS or (load.total() < enough and not load.errors and load.alive()):
                    roll(load, fleet, fixed)
                    rounds += 1
                    time.sleep(FORGOTTEN)
                load.end()
                jobs_end(load, front)
                said = [line for line in (front.files / "said").read_text().splitlines() if "[error]" in line and "(111:" not in line]
            print(f"  {dict(load.count)} in all, the longest took {load.longest:.1f} s")
            check(f"no error of {load.total()} requests", not load.errors and load.total() >= enough,
                  f"{len(load.errors)}, for example " + "; ".join(load.errors[:5]) + "; nginx said: " + "; ".join(said[-8:]))
        finally:
            fleet.close()


if not postgres_programs() or not tool("nginx"):
    skip("a rolling restart", "postgresql or nginx-light is not installed")
else:
    try:
        rolling(False, ENOUGH)
        rolling(True, ENOUGH // 4)
    except (OSError, http.client.HTTPException, RuntimeError, KeyError, ValueError) as error:
        check("it runs", False, repr(error))
sys.exit(summary())
