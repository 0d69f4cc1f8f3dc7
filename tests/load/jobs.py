"""Jobs under load: members a second a core against the engine by itself, jobs accepted a second, from submit to start,
from DELETE to the end of the computation.

Leaves to others: rows and failures (load.py), daemons and stores (servers.py, tests/drill). Invariant: traffic stays on
loopback and Unix sockets; a store is on a disk, with its durability as it is shipped.
"""
import contextlib
import http.client
import itertools
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from servers import CORES, TOP, client, message

sys.path.append(str(TOP / "tests/drill"))
from house import Daemon  # noqa: E402
from places import place, postgres_programs  # noqa: E402

SIDE, RTOL = 1000, 1e-9
DOUBLE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
AXES = ",".join(f'{{"vary":"theta","arm":{arm},"start":-3,"stop":3,"count":{SIDE}}}' for arm in (1, 2))
MAP = f'{{{DOUBLE},"duration":20,"rtol":{RTOL},"atol":{RTOL},"observables":["first_flip"],"grid":[{AXES}]}}'
LITTLE = f'{{{DOUBLE},"state":{{"phi":[1,2]}}}}'
ASYNC = {"Prefer": "respond-async"}


@contextlib.contextmanager
def house(build, kind, roles, *options):
    """A store of that kind and daemons on it; PostgreSQL brings its processes' time with it, and has the memory that it
    is shipped with."""
    more = {} if kind == "sqlite" else {"buffers": "128MB", "connections": 3 * len(roles) + 10}
    with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as logs, place(kind, **more) as store, contextlib.ExitStack() as stack:
        daemons = []
        for role, workers in roles:
            daemon = Daemon(TOP / build, store.url, role, logs, ("--workers", str(workers), *options))
            stack.callback(daemon.kill, 15)
            daemons.append(daemon)
        yield store, daemons


def seconds_of(pids):
    """Processor seconds of processes and what they left behind."""
    total = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            total += int(fields[11]) + int(fields[12])
    return total / os.sysconf("SC_CLK_TCK")


def database(store):
    """The pids of a PostgreSQL; none of SQLite, which is in the daemons."""
    server = getattr(store, "server", None)
    return [server.pid, *pathlib.Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split()] if server else []


def until_done(daemon, location):
    while (view := json.loads(daemon.ask("GET", location, seconds=60)[2]))["status"] in ("accepted", "running"):
        time.sleep(0.05)
    return view


def engine(build, share):
    out = subprocess.run([TOP / build / "tests/bench/jobs/engine", str(SIDE), str(RTOL), str(share)], capture_output=True, text=True, check=True)
    return json.loads(out.stdout)


def members(load):
    """A million double pendulums of 20 s as a job, by two workers: one process on SQLite, two on PostgreSQL."""
    for kind, roles, asked in (("sqlite", (("all", 2),), 0.9), ("postgres", (("api", 1), ("worker", 1), ("worker", 1)), 0.85)):
        name = f"a job's members, {kind}"
        if kind == "postgres" and not postgres_programs():
            load.skip(name, "postgresql is not installed")
            continue
        with house(load.BUILD, kind, roles) as (store, daemons):
            own = [engine(load.BUILD, 10) for _ in range(2)]
            pids = [daemon.process.pid for daemon in daemons] + database(store)
            before, begin = seconds_of(pids), time.monotonic()
            status, headers, text = daemons[0].ask("POST", "/v1/ensembles", MAP, ASYNC)
            if status != 202:
                load.fail(f"{name}: status {status}: {text[:300]}")
                continue
            view = until_done(daemons[0], headers["Location"])
            wall, used = time.monotonic() - begin, seconds_of(pids) - before
            own += [engine(load.BUILD, 10) for _ in range(2)]
            parts = store.rows("SELECT COUNT(*) FROM parts")[0][0]
        if view["status"] != "successful":
            load.fail(f"{name}: {view}")
            continue
        best = max(figures["members"] / figures["seconds"] for figures in own)
        by_clock = SIDE * SIDE / wall / 2
        load.ratio_row(name, SIDE * SIDE / used, best, asked, "members/s a core, by processor time",
                       f"{parts} parts in {wall:.1f} s; by the clock {by_clock:.0f} a second on each of two cores, {by_clock / best:.2f}x, "
                       "which says something on a machine that does nothing else")


def dispatch(load):
    """Small jobs, each on SQLite's disk before its 202; computed meanwhile."""
    with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as directory:
        path = load.file_of(directory, "job.http", message("/v1/forces", LITTLE, "Prefer: respond-async\r\n"))
        for role in ("api", "all"):
            with house(load.BUILD, "sqlite", ((role, 2),), "--max-client-jobs", "1000000", "--max-client-queue", "1000") as (store, (daemon,)):
                best = max((client(load.BUILD, daemon, [f"{path}=202"], "--connections", "64", seconds=2.0) for _ in range(3)),
                           key=lambda figures: figures["rate"])
                if best["wrong"] or best["broken"] or best["refused"]:
                    load.fail(f"dispatch: {best}")
                jobs = store.rows("SELECT COUNT(*), SUM(state = 2) FROM jobs")[0]
            more = "accepted only" if role == "api" else "accepted and computed"
            load.row(f"small jobs, {more}", f"{best['rate']:.0f}", "1000", f"{best['rate'] / 1000:.2f}x", "1x",
                     "jobs/s" + ("" if best["rate"] >= 1000 else "   (short)"),
                     f"p50 {best['p50']:.1f} p99 {best['p99']:.1f} ms; {jobs[0]} kept, {jobs[1]} computed so far")


def start(load):
    """From the first byte of a request to the instant at which a worker has its part, nothing else going on."""
    split = (("api", 1), ("worker", 1))
    for kind, roles in (("sqlite", (("all", 1),)), ("sqlite", split), ("postgres", (("all", 1),)), ("postgres", split)):
        name = f"submit to start, {kind}, {' and '.join(role for role, _ in roles)}"
        if kind == "postgres" and not postgres_programs():
            load.skip(name, "postgresql is not installed")
            continue
        took = []
        with house(load.BUILD, kind, roles) as (store, daemons):
            for _ in range(60):
                time.sleep(0.03)
                begin = time.time()
                _, headers, _ = daemons[0].ask("POST", "/v1/forces", LITTLE, ASYNC)
                until_done(daemons[0], headers["Location"])
                job = headers["Location"].rsplit("/", 1)[1]
                took.append(1e-3 * store.rows(f"SELECT started FROM jobs WHERE id = '{job}'")[0][0] - 1e3 * begin)
        took.sort()
        middle = statistics.median(took)
        load.row(name, f"{middle:.2f}", "20", f"{middle / 20:.2f}x", "< 1x", "ms" + ("" if middle < 20 else "   (short)"),
                 f"least {took[0]:.2f}, nine in ten below {took[len(took) * 9 // 10]:.2f}, most {took[-1]:.2f}")


class Busy:
    """Looks a thousand times a second whether workers compute, on a thread of its own."""

    def __init__(self, daemons):
        self.lines = [http.client.HTTPConnection("127.0.0.1", daemon.port, timeout=10) for daemon in daemons]
        self.seen, self.begun, self.over = 0.0, 0.0, False  # when one was last busy, when the last look began
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.over:
            begun = time.monotonic()
            for line in self.lines:
                line.request("GET", "/metrics")
                if b"\npendulumd_workers_busy 0\n" not in line.getresponse().read():
                    self.seen = time.monotonic()
            self.begun = begun
            time.sleep(0.001)

    def until_at_rest(self, since):
        """Waits until nobody was seen to compute for a while; when that was last so."""
        while self.begun < max(self.seen, since) + 0.15:
            time.sleep(0.01)
        return max(self.seen, since)

    def close(self):
        self.over = True
        self.thread.join(10)
        for line in self.lines:
            line.close()


STOPS = 200  # on each store, with each division of the work
LONG = [("/v1/ensembles", MAP.replace(f'"count":{SIDE}', '"count":4000')),
        ("/v1/trajectories", f'{{{DOUBLE},"times":{{"start":0,"stop":1000000,"count":3}}}}')]


def cancel(load):
    """From the first byte of a DELETE to its answer, and to the instant at which no worker computes any more."""
    split = (("api", 1), ("worker", 2))
    for kind, roles in (("sqlite", (("all", 2),)), ("sqlite", split), ("postgres", (("all", 2),)), ("postgres", split)):
        name = f"{kind}, {' and '.join(role for role, _ in roles)}"
        if kind == "postgres" and not postgres_programs():
            load.skip(f"DELETE to the end, {name}", "postgresql is not installed")
            continue
        answered, ended = [], []
        with house(load.BUILD, kind, roles) as (_, daemons), contextlib.closing(Busy(daemons)) as busy:
            jobs = itertools.cycle(LONG)
            for i in range(STOPS):
                path, body = next(jobs)
                _, headers, _ = daemons[0].ask("POST", path, body, ASYNC)
                while json.loads(daemons[0].ask("GET", headers["Location"])[2])["status"] != "running":
                    time.sleep(0.005)
                time.sleep(0.05 + 0.37 * i / STOPS)
                begin = time.monotonic()
                status, _, text = daemons[0].ask("DELETE", headers["Location"])
                answered.append(1e3 * (time.monotonic() - begin))
                if status != 200:
                    load.fail(f"DELETE, {name}: status {status}: {text[:300]}")
                ended.append(1e3 * (busy.until_at_rest(begin) - begin))
        for what, took in (("its answer", sorted(answered)), ("the end", sorted(ended))):
            high = took[len(took) * 99 // 100]
            load.row(f"DELETE to {what}, {name}", f"{high:.1f}", "100", f"{high / 100:.2f}x", "< 1x", "ms, of 99 in 100" + ("" if high < 100 else "   (short)"),
                     f"median {statistics.median(took):.1f}, most {took[-1]:.1f}, of {len(took)}")


WORKERS = (1, 2, 4, 16, 64)
DRAIN_SECONDS, DRAIN_WARM = 5, 3


def drained(build, count, directory, seconds=DRAIN_SECONDS, store_is="postgres"):
    """Small jobs of two clients a second, accepted and computed, while one api and `count` workers share a database; after
    a first round, in which each connection prepares its statements."""
    files = []
    for name in ("one", "other"):
        files.append(pathlib.Path(directory, f"{name}.http"))
        files[-1].write_bytes(message("/v1/forces", LITTLE, f"Authorization: Bearer a-{name}-of-two-clients-that-send\r\nPrefer: respond-async\r\n"))
    roles = (("api", 1), *((("worker", 1),) * count))
    with house(build, store_is, roles, "--max-client-jobs", "1000000", "--max-client-queue", "1000") as (store, daemons):
        def send(seconds):
            return client(build, daemons[0], [f"{file}=202" for file in files], "--connections", "32", seconds=seconds, core=",".join(map(str, CORES)))

        def ended(test="="):
            return store.rows(f"SELECT COUNT(*) FROM jobs WHERE state {test} 2")[0][0]

        def spent():
            return seconds_of([daemon.process.pid for daemon in daemons] + database(store))
        send(DRAIN_WARM)
        while ended("<"):
            time.sleep(0.1)
        used, before, begin = spent(), ended(), time.monotonic()
        figures = send(seconds)
        took = time.monotonic() - begin
        done, used = ended() - before, spent() - used
    if figures["wrong"] or figures["broken"]:
        raise RuntimeError(f"{count} workers: {figures}")
    return done / took, figures["rate"], 1e6 * used / max(done, 1)


def workers(load):
    """More workers never drain fewer jobs: each number of them in turn, three times, the best counts."""
    if not postgres_programs():
        load.skip("small jobs drained, postgres", "postgresql is not installed")
        return
    best = {}
    with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as directory:
        for _ in range(3):
            for count in WORKERS:
                best[count] = max(drained(load.BUILD, count, directory), best.get(count, (0, 0, 0)))
    fewer = 0
    for count, (rate, accepted, us) in best.items():
        load.ratio_row(f"small jobs drained, postgres, {count} workers", rate, max(fewer, rate), 0.9, "jobs/s, of the most with fewer workers",
                       f"{accepted:.0f} accepted a second meanwhile; {us:.0f} us of processor a job, database and daemons")
        fewer = max(fewer, rate)


LINES = {"members": members, "dispatch": dispatch, "start": start, "cancel": cancel, "workers": workers}
