"""A store that keeps or owes a million jobs: how long submitting, listing, starting and sweeping take there, and how many
small jobs a second are accepted and computed.

Leaves to others: rows and failures (load.py), daemons and stores (servers.py, tests/drill). Invariant: the million are
copies of one job that went through the daemon, made by statements together with the sums that count them.
"""
import contextlib
import http.client
import statistics
import tempfile
import time

from jobs import ASYNC, LITTLE, database, house, seconds_of, until_done
from house import Daemon
from places import postgres_programs
from servers import TOP, client, message

JOBS, EXPIRED = 1_000_000, 100_000
STORES = ("sqlite", "postgres")
MANY = ("--max-client-jobs", "100000000", "--max-client-queue", "1000", "--max-client-bytes", "1000G", "--max-store-bytes", "1000G")
COLUMNS = "client, operation, request, digest, state, parts, begun, done, waiting, chained, ready, rank, created, started, finished, expires, bytes, message, part_us, held, seal, title, version"
NUMBERS = {"sqlite": "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {count}) SELECT i FROM n) AS n",
           "postgres": "generate_series(1, {count}) AS n(i)"}
ID = {"sqlite": "printf('%026d', i)", "postgres": "lpad(i::text, 26, '0')"}


def copies(store, job, count, waiting):
    """Copies a job, as it was accepted or as it ended, with all that belongs to it."""
    numbers, name = NUMBERS[store.name].format(count=count), ID[store.name]
    columns = COLUMNS.replace("expires", "expires + i") if not waiting else COLUMNS
    store.rows(f"INSERT INTO jobs (id, {COLUMNS}) SELECT {name}, {columns} FROM jobs, {numbers} WHERE id = '{job}'")
    if not waiting:
        store.rows(f"INSERT INTO parts (job, number, state, attempt, kills, worker, lease, start, bytes) SELECT {name}, number, state, attempt, kills, worker, lease, start, bytes FROM parts, {numbers} WHERE job = '{job}'")
        store.rows(f"INSERT INTO results (job, part, chunk, data, seal) SELECT {name}, part, chunk, data, seal FROM results, {numbers} WHERE job = '{job}'")
    state = "accepted" if waiting else "successful"
    size = f"{count} * (SELECT bytes + held FROM jobs WHERE id = '{job}')"
    store.rows(f"UPDATE totals SET {state} = {state} + {count}, bytes = bytes + {size}, waiting = waiting + {count if waiting else 0} "
               "WHERE place = (SELECT MIN(place) FROM totals)")
    more = f", jobs = jobs + {count}, ready = ready + {count}" if waiting else ""
    store.rows(f"UPDATE clients SET bytes = bytes + {size}{more} WHERE name = (SELECT client FROM jobs WHERE id = '{job}')")


def submit(daemon):
    status, headers, text = daemon.ask("POST", "/v1/forces", LITTLE, ASYNC)
    if status != 202:
        raise RuntimeError(f"a small job is answered {status}: {text[:300]}")
    return headers["Location"]


def times(daemon, count, method, path, body=None, headers=None):
    """Milliseconds of requests on one connection, one after the other, sorted."""
    took = []
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", daemon.port, timeout=120)) as line:
        for _ in range(count):
            begin = time.monotonic()
            line.request(method, path, body, {"Content-Type": "application/json"} | (headers or {}))
            line.getresponse().read()
            took.append(1e3 * (time.monotonic() - begin))
    return sorted(took)


def kept(load):
    """A million jobs that have ended: submit, list, start, and a sweep of a tenth of them."""
    for kind in STORES:
        if kind == "postgres" and not postgres_programs():
            load.skip(f"a million kept jobs, {kind}", "postgresql is not installed")
            continue
        with house(load.BUILD, kind, (("all", 1),), *MANY) as (store, (daemon,)):
            location = submit(daemon)
            until_done(daemon, location)
            fresh = times(daemon, 500, "POST", "/v1/forces", LITTLE, ASYNC)
            while daemon.metric("pendulumd_job_parts_waiting"):
                time.sleep(0.2)
            begin = time.monotonic()
            copies(store, location.rsplit("/", 1)[1], JOBS, False)
            filled = time.monotonic() - begin
            begin = time.monotonic()
            with beside(load, store, "api") as late:
                late.ask("GET", "/v1/jobs")
                started = time.monotonic() - begin
            took = times(daemon, 1000, "POST", "/v1/forces", LITTLE, ASYNC)
            high, middle = took[len(took) * 99 // 100], statistics.median(took)
            load.row(f"submit, a million kept, {kind}", f"{high:.1f}", f"{fresh[495]:.1f}", f"{high / fresh[495]:.2f}x", "20",
                     "ms, of 99 in 100; beside it a new store's" + ("" if high < 20 else "   (short)"),
                     f"median {middle:.2f} and {statistics.median(fresh):.2f}, most {took[-1]:.1f}; filled in {filled:.0f} s")
            took = times(daemon, 200, "GET", "/v1/jobs?limit=100")
            load.row(f"list, a million kept, {kind}", f"{took[198]:.1f}", "-", "-", "-", "ms, of 99 in 100", f"median {statistics.median(took):.2f}")
            load.row(f"start, a million kept, {kind}", f"{started:.2f}", "1", f"{started:.2f}x", "< 1x", "s, to the first list" + ("" if started < 1 else "   (short)"))
            sweep(load, store, daemon)


@contextlib.contextmanager
def beside(load, store, role):
    """One more daemon on a store, for a block."""
    with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as logs:
        daemon = Daemon(TOP / load.BUILD, store.url, role, logs, MANY)
        try:
            yield daemon
        finally:
            daemon.kill(15)


def sweep(load, store, daemon):
    """A tenth of them expires at one instant; what is submitted meanwhile does not wait long."""
    store.rows(f"UPDATE jobs SET expires = 1 + expires % 1000000 WHERE id <= '{EXPIRED:026d}'")
    left, took, begin = f"SELECT COUNT(*) FROM jobs WHERE id <= '{EXPIRED:026d}'", [], time.monotonic()
    while store.rows(left)[0][0] and time.monotonic() - begin < 300:
        took += times(daemon, 50, "POST", "/v1/forces", LITTLE, ASYNC)
    seconds = time.monotonic() - begin
    took.sort()
    load.row(f"sweep of {EXPIRED} expired, {store.name}", f"{seconds:.1f}", "10", f"{seconds / 10:.2f}x", "< 1x",
             "s" + ("" if seconds < 10 else "   (short)"), f"{EXPIRED / seconds:.0f} a second; submit meanwhile: median {statistics.median(took):.1f} ms, "
             f"99 in 100 below {took[len(took) * 99 // 100]:.1f}, of {len(took)}")


def owed(load):
    """A million small jobs wait: how many more are accepted a second, and how many two workers compute."""
    for kind in STORES:
        if kind == "postgres" and not postgres_programs():
            load.skip(f"a million waiting jobs, {kind}", "postgresql is not installed")
            continue
        with house(load.BUILD, kind, (("api", 1),), *MANY) as (store, (daemon,)):
            path = load.file_of(str(store.directory), "job.http", message("/v1/forces", LITTLE, "Prefer: respond-async\r\n"))
            job = submit(daemon).rsplit("/", 1)[1]
            copies(store, job, JOBS, True)
            pids = [daemon.process.pid] + database(store)
            before = seconds_of(pids)
            figures = client(load.BUILD, daemon, [f"{path}=202"], "--connections", "64", seconds=5.0)
            used = seconds_of(pids) - before
            if figures["wrong"] or figures["broken"] or figures["refused"]:
                load.fail(f"accepting beside a million: {figures}")
            load.row(f"accepted, a million waiting, {kind}", f"{figures['rate']:.0f}", "5000", f"{figures['rate'] / 5000:.2f}x", "1x",
                     "jobs/s" + ("" if figures["rate"] >= 5000 else "   (short)"),
                     f"p50 {figures['p50']:.1f} p99 {figures['p99']:.1f} ms; {1e6 * used / (5 * figures['rate']):.0f} us of processor a job")
            drain(load, store, daemon)


def drain(load, store, daemon):
    """Two worker processes compute what waits."""
    with contextlib.ExitStack() as stack:
        workers = [stack.enter_context(beside(load, store, "worker")) for _ in range(2)]
        time.sleep(2)
        pids = [each.process.pid for each in workers] + database(store)
        before, begin, first = seconds_of(pids), time.monotonic(), done(store)
        time.sleep(10)
        seconds, count, used = time.monotonic() - begin, done(store) - first, seconds_of(pids) - before
    rate = count / seconds
    load.row(f"computed, a million waiting, {store.name}", f"{rate:.0f}", "5000", f"{rate / 5000:.2f}x", "1x", "jobs/s, by two workers" + ("" if rate >= 5000 else "   (short)"),
             f"{1e6 * used / max(count, 1):.0f} us of processor a job, the database's among them")


def done(store):
    return store.rows("SELECT SUM(successful) FROM totals")[0][0]


LINES = {"kept": kept, "owed": owed}
