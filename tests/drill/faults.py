"""What goes wrong, a function each: one round on a house that stands. A round ends when every job has ended.

Leaves to others: how a daemon or a store is handled (house.py, places.py), rounds and counts (drill.py).
Invariant: a fault strikes at a random instant while parts are computed; the drill says how many were held.
"""
import concurrent.futures
import contextlib
import hashlib
import itertools
import json
import os
import pathlib
import shutil
import signal
import struct
import time

from house import JOBS, LEASE, OTHERS, PATIENCE, VARIOUS, walk
from places import small_disk
from proxy import Proxy


class Skip(Exception):
    """A fault that cannot be had here; says why."""


def several(house):
    return [house.submit(kind) for kind in ("map", "walk", "map")]


# --- processes

def worker_killed(house):
    """kill -9 of a worker in mid-part; another takes over, a new one comes."""
    jobs = several(house)
    house.nap(0, 0.3)
    house.kill(house.pick("worker"))
    house.start("worker")
    house.finish(jobs)


def crowd_killed(house):
    """kill -9 of one worker in eight of many, four times, while they have jobs of all kinds: none of the jobs is to blame."""
    jobs = several(house) + several(house) + several(house)
    for _ in range(4):
        house.nap(0, 0.5)
        for _ in range(max(1, sum(daemon.role == "worker" for daemon in house.daemons) // 8)):
            house.kill(house.pick("worker"))
            house.start("worker")
    house.finish(jobs)


def all_killed(house):
    """kill -9 of one process after another, the api too, while jobs of every method and operation are computed."""
    jobs = [house.submit(kind) for kind in (JOBS | VARIOUS)]
    for role in ("worker", "api", "worker", "worker", "api"):
        house.nap(0, 0.3)
        house.kill(house.pick(role))
        house.start(role)
    house.finish(jobs)


def daemon_killed(house):
    """kill -9 of the only process, at any instant, while a client submits."""
    with concurrent.futures.ThreadPoolExecutor(1) as client:
        jobs = client.submit(several, house)
        for longest in (0.2, 0.3):
            house.nap(0, longest)
            house.kill(house.pick("all"))
            house.start("all")
        house.finish(jobs.result())


def worker_stopped(house):
    """SIGSTOP past the lease, then SIGCONT: what it had is another's by then, and it writes nothing."""
    jobs = several(house)
    house.nap(0, 0.3)
    worker = house.pick("worker")
    lost = worker.metric('pendulumd_job_parts_total{end="lost"}')
    worker.stopped = True
    worker.process.send_signal(signal.SIGSTOP)
    house.note("held", house.held(worker))
    house.nap(1.2 * LEASE, 2.5 * LEASE)
    worker.process.send_signal(signal.SIGCONT)
    worker.stopped = False
    house.finish(jobs)
    house.note("refused", int(worker.metric('pendulumd_job_parts_total{end="lost"}') - lost))


def in_one_part(house):
    house.part = "3600"


def poison(house):
    """A part that ends four workers, three of them alone, is given up, and says so; other jobs stand."""
    other = house.submit("walk")
    house.finish([other])
    job, _ = house.submit("long")
    house.accepted[job] = "failed"
    for _ in range(4):
        worker = house.pick("worker")
        end = time.monotonic() + PATIENCE
        while not house.held(worker) and time.monotonic() < end:
            time.sleep(0.01)
        house.kill(worker)
        house.start("worker")
    view = house.wait(job, "failed")
    if "3 workers ended" not in view.get("message", ""):
        house.wrong.append(f"a poisonous job is told so: {view}")
    house.finish([house.submit("map")])


# --- the database and the way to it

RESTARTS = itertools.cycle((signal.SIGINT, signal.SIGKILL, signal.SIGQUIT))


def database_restarted(house):
    """PostgreSQL ends in order, by kill -9, or at once, while parts are computed."""
    jobs = several(house)
    house.nap(0, 0.3)
    house.place.restart(next(RESTARTS))
    jobs.append(house.submit("walk"))
    house.finish(jobs)


def through_proxies(house):
    """Every role gets its own way to the database."""
    house.proxies = [Proxy(house.place.socket) for _ in range(2)]
    for role, proxy in zip(("api", "worker"), house.proxies):
        house.url[role] = f"postgresql://pendulumd@127.0.0.1:{proxy.port}/postgres?sslmode=disable&gssencmode=disable"


def connections_cut(house):
    """The lines to the database are silent, or reset and barred, or first the one and then the other, for longer than a lease."""
    jobs = several(house)
    house.nap(0, 0.3)
    which = house.random.choice(([0], [1], [0, 1]))
    how = house.random.choice(("silent", "cut", "both"))
    for i in which:
        if how != "cut":
            house.proxies[i].freeze()
        if how == "cut":
            house.proxies[i].cut()
    house.nap(1.2 * LEASE, 2.5 * LEASE)
    for i in which:
        if how == "both":
            house.proxies[i].cut()
        house.proxies[i].mend()
    jobs.append(house.submit("walk"))
    house.finish(jobs)


def connections_swallowed(house):
    """The lines to the database stand and nothing comes back, for longer than anybody may wait: every process says that it
    is not ready, and goes on when something comes."""
    jobs = several(house)
    house.nap(0, 0.3)
    begin = time.monotonic()
    for proxy in house.proxies:
        proxy.freeze()
    await_ready(house, 503)
    house.times.append(time.monotonic() - begin)
    for proxy in house.proxies:
        proxy.mend()
    await_ready(house, 200)
    jobs.append(house.submit("walk"))
    house.finish(jobs)


def await_ready(house, wanted):
    """Waits until /readyz?need=jobs of every process has that status."""
    end = time.monotonic() + PATIENCE
    for daemon in house.daemons:
        while (status := daemon.ask("GET", "/readyz?need=jobs")[0]) != wanted and time.monotonic() < end:
            time.sleep(0.02)
        if status != wanted:
            house.wrong.append(f"/readyz?need=jobs of a {daemon.role} stays {status} and is not {wanted}")


def through_proxies_timed(house):
    through_proxies(house)
    note_times(house)


def tell_silence(house):
    times = sorted(house.times)
    return f"all said so after {times[len(times) // 2]:.1f} s in the median, {times[-1]:.1f} at most" if times else ""


# --- clients

def doubled(house):
    """Eight clients send one request with one key at once, to two processes: one job."""
    key = f"doubled-{next(house.keys)}"
    kind = house.random.choice(list(JOBS))
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        jobs = set(pool.map(lambda _: house.submit(kind, key=key), range(8)))
    if len(jobs) != 1:
        house.wrong.append(f"one key made {len(jobs)} jobs")
    house.finish(jobs)


def cancelled(house):
    """DELETE while it runs: it stops everywhere, nothing of it is kept, its neighbour goes on."""
    job, _ = house.submit(house.random.choice(("long", "big")))
    house.wait(job, "running")
    house.nap(0, 0.2)
    house.accepted[job] = "dismissed"
    begin = time.monotonic()
    status, _, _ = house.ask("DELETE", f"/v1/jobs/{job}")
    workers = [daemon for daemon in house.daemons if daemon.role == "worker"]
    while any(worker.metric("pendulumd_workers_busy") for worker in workers) and time.monotonic() < begin + PATIENCE:
        pass
    house.times.append(time.monotonic() - begin)
    results, _, _ = house.ask("GET", f"/v1/jobs/{job}/results")
    if status != 200 or results != 409 or house.look(job).get("status") != "dismissed":
        house.wrong.append(f"a DELETE is answered {status}, then results are {results}")
    house.finish([house.submit("map")])


def note_times(house):
    house.times = []


def tell_times(house):
    times = sorted(house.times)
    return f"computation stopped after {1e3 * times[len(times) // 2]:.0f} ms in the median, {1e3 * times[-1]:.0f} at most" if times else ""


# --- the machine

BALLAST = 6 << 20  # bytes that somebody else has on the database's disk, and can do without
SPARE = 1 << 20    # bytes that are kept for the drill itself: on a full disk a database cannot even tidy up


def on_small_disk(house):
    """What a store writes lies on a file system of sixteen megabytes."""
    place = house.place
    directory = os.path.join(place.directory, "small")
    house.disk, house.ballast = small_disk(directory, "16m" if place.name == "sqlite" else "25m"), os.path.join(directory, "ballast")
    try:
        house.disk.__enter__()
    except PermissionError as error:
        raise Skip(str(error)) from None
    if place.name == "sqlite":
        place.use(directory)
    else:
        os.chown(directory, place.user["user"], place.user["group"])
        place.rows(f"CREATE TABLESPACE small LOCATION '{directory}'")
        place.rows("ALTER ROLE pendulumd SET default_tablespace = small")


def take(path, size):
    """A file that takes so many bytes of its disk."""
    with open(path, "wb") as file:
        os.posix_fallocate(file.fileno(), 0, size)


def spare(house):
    return pathlib.Path(house.ballast).with_name("spare")


def off_small_disk(house):
    if house.place.name == "postgres":  # it writes what it has left before it ends
        pathlib.Path(house.ballast).unlink(missing_ok=True)
        spare(house).unlink(missing_ok=True)
    house.place.close()
    house.disk.__exit__(None, None, None)


def room(house):
    """Bytes that are free on the small disk."""
    disk = os.statvfs(os.path.dirname(house.ballast))
    return disk.f_bavail * disk.f_frsize


def tidy(house):
    """Gives the file system back what removed rows have left: PostgreSQL does so by itself within minutes, and not whole."""
    spare(house).unlink(missing_ok=True)
    for table in ("results", "jobs", "parts", "scenes"):
        for command in ("VACUUM", "VACUUM FULL"):
            house.place.rows(f"{command} {table}")
    take(spare(house), SPARE)


def load_disk(house, loaded):
    if house.place.name == "postgres" and loaded:
        tidy(house)
        take(house.ballast, BALLAST)
    elif house.place.name == "postgres":
        os.unlink(house.ballast)


def fill_disk(house):
    """Somebody else takes what is left of the disk, to the last byte."""
    with open(house.ballast, "wb", buffering=0) as file, contextlib.suppress(OSError):
        while file.write(bytes(1 << 12)):
            pass


def disk_full(house):
    """Results that do not fit: the job fails and says why, others stand, and when it has gone there is room again. SQLite
    keeps room for that, and waits only where somebody else takes it, as one does in a round of two; PostgreSQL waits
    until somebody makes some."""
    stands = house.submit("walk")
    house.finish([stands])
    load_disk(house, True)
    robbed = house.place.name == "sqlite" and house.random.random() < 0.5
    jobs = []
    for _ in range(10):
        status, fields, text = house.post("wide", patience=0)
        if status == 202:
            jobs.append(fields["Location"].rsplit("/", 1)[1])
        elif status != 503 or b"disk is full" not in text:
            house.wrong.append(f"a job for a full disk is answered {status}: {text[:300]}")
        house.note("not accepted", status != 202)
    if robbed:
        house.nap(0, 0.4)
        fill_disk(house)
        house.nap(0.1, 0.6)
        os.unlink(house.ballast)
    met, end = False, time.monotonic() + 30
    while not met and any(house.look(job)["status"] in ("accepted", "running") for job in jobs) and time.monotonic() < end:
        time.sleep(0.02)
        met = room(house) < 1 << 19
    house.nap(0.1, 0.4)
    house.finish([stands])
    if house.place.name == "postgres":
        load_disk(house, False)
    views = [house.wait(job, "successful", "failed") for job in jobs]
    # where not even a lease can be written, workers seem silent
    words = ("disk is full", "stopped responding") if robbed or house.place.name == "postgres" else ("disk is full",)
    for view in views:
        if view.get("status") == "failed" and not any(word in view["message"] for word in words):
            house.wrong.append(f"a job failed of something else: {view}")
    full = sum(view.get("status") == "failed" for view in views)
    house.note("failed", full)
    # where room was made soon enough, all may fit in the end
    if not jobs or not (met or full or len(jobs) < 10):
        house.wrong.append(f"{len(jobs)} jobs were accepted, and none met a full disk")
    dismiss(house, *jobs, stands[0])
    if house.place.name == "postgres":
        tidy(house)
    after = house.submit("walk")
    house.finish([after])
    dismiss(house, after[0])


def erased_when_full(house):
    """What a client has is erased on a disk that it has filled, piece by piece; what another has stays."""
    stands = house.submit("walk")
    house.finish([stands])
    load_disk(house, True)
    api, jobs, scenes, refused = house.pick("api"), [], [], 0
    token = {"Authorization": f"Bearer one-who-fills-the-disk-{next(house.keys)}"}
    path, body = OTHERS["wide"]
    while refused < 4 and len(jobs) < 60:
        status, fields, text = api.ask("POST", path, body, token | {"Prefer": "respond-async"})
        jobs += [fields["Location"]] if status == 202 else []
        scene = f'{{"request":{walk(len(scenes) + 1, 3)},"title":"{"x" * 150}"}}'
        added, _, other = api.ask("POST", "/v1/scenes", scene, token)
        scenes += [f"/v1/scenes/{json.loads(other)['id']}"] if added == 201 else []
        refused = refused + 1 if 503 in (status, added) else 0
        if status not in (202, 503) or added not in (201, 503):
            house.wrong.append(f"a full disk is answered {status}, {added}: {text[:300]} {other[:300]}")
            break
        house.nap(0.01, 0.05)
    end = time.monotonic() + 30
    while not (met := refused or room(house) < 1 << 19 or any(b"disk is full" in api.ask("GET", job, headers=token)[2] for job in jobs)) and time.monotonic() < end:
        time.sleep(0.1)
    if not met:
        house.wrong.append(f"{len(jobs)} jobs and {len(scenes)} scenes do not fill the disk")
    status, _, text = api.ask("DELETE", "/v1/clients/me", None, token)
    if status != 204:
        house.wrong.append(f"{len(jobs)} jobs and {len(scenes)} scenes on a disk with {room(house)} bytes left are not erased: {status} {text[:300]}")
    left = [place for place in jobs + scenes if api.ask("GET", place, headers=token)[0] != 404]
    if left:
        house.wrong.append(f"{len(left)} of {len(jobs) + len(scenes)} are there after they were erased, as {left[0]}")
    house.note("jobs and scenes erased", len(jobs) + len(scenes))
    if house.place.name == "postgres":
        load_disk(house, False)
    house.finish([stands])
    dismiss(house, stands[0])


def dismiss(house, *jobs):
    for job in jobs:
        house.accepted[job] = "dismissed"
        house.ask("DELETE", f"/v1/jobs/{job}")
    house.settle()


# --- results as files

FILE_FAULTS = itertools.cycle(("killed", "stopped", "away", "full"))


def in_files(house):
    """Results are files on a file system of forty megabytes."""
    directory = pathlib.Path(house.directory, "disk")
    house.disk, house.ballast, house.folder = small_disk(directory, "40m"), directory / "ballast", directory / "results"
    try:
        house.disk.__enter__()
    except PermissionError as error:
        raise Skip(str(error)) from None
    house.folder.mkdir()
    house.more = ("--results", f"file://{house.folder}")


def files_robbed(house):
    """While parts are written as files, workers are killed, or stopped past their lease so that two write one part, or
    the folder goes away and comes back, or its disk is full. Then the store names every file, with its digest."""
    jobs, what = several(house) + several(house), next(FILE_FAULTS)
    house.nap(0, 0.4)
    workers = [daemon for daemon in house.daemons if daemon.role == "worker"]
    some = house.random.sample(workers, max(1, len(workers) // 8))
    house.note(what)
    if what == "killed":
        for worker in some:
            house.kill(worker)
            house.start("worker")
    elif what == "stopped":
        for number, seconds in ((signal.SIGSTOP, 2 * LEASE), (signal.SIGCONT, 0)):
            for worker in some:
                worker.stopped = number == signal.SIGSTOP
                worker.process.send_signal(number)
            time.sleep(seconds)
    elif what == "away":
        os.rename(house.folder, f"{house.folder}.aside")
        house.nap(0.2, 2 * LEASE)
        os.rename(f"{house.folder}.aside", house.folder)
    else:
        fill_disk(house)
        house.nap(0.2, 1)
        os.unlink(house.ballast)
        for job, kind in list(jobs):
            view = house.wait(job, "successful", "failed")
            if view["status"] == "failed" and "disk" in view["message"]:
                house.accepted[job] = "failed"
                house.note("failed for want of space")
                jobs.remove((job, kind))
    house.finish(jobs)
    for job, _ in jobs:
        files_right(house, job)
    dismiss(house, *(job for job, _ in jobs[1:]))
    left = lambda: {path.name for path in house.folder.iterdir()} - {f"job={job}" for job, word in house.accepted.items() if word == "successful"}
    end = time.monotonic() + 3 * LEASE
    while left() and time.monotonic() < end:
        time.sleep(0.1)
    # whom a kill met between its file and its row leaves a folder of a job that has ended, until it is as old as results get
    house.note("left for the sweep", len(left()))
    if left() and what != "killed":
        house.wrong.append(f"{what}: files of no job: {left()}")
    for name in left():
        shutil.rmtree(house.folder / name)


def files_right(house, job):
    """The manifest names what is there: bytes, digests, and rows and bytes that agree with the job's."""
    status, _, text = house.ask("GET", f"/v1/jobs/{job}/results?manifest=true")
    files = json.loads(text)["files"] if status == 200 else []
    for file in files:
        data = pathlib.Path(file["href"][len("file://"):]).read_bytes()
        if len(data) != file["bytes"] or hashlib.sha256(data).hexdigest() != file["sha256"]:
            house.wrong.append(f"{job}: {file} has {len(data)} other bytes")
    said, kept = house.place.rows(f"SELECT bytes, (SELECT COALESCE(SUM(LENGTH(data)), 0) FROM results WHERE job = jobs.id) FROM jobs WHERE id = '{job}'")[0]
    if said != kept + sum(file["bytes"] for file in files) or status not in (200, 409):
        house.wrong.append(f"{job}: {said} bytes are counted, {kept} are in the store, status {status}")


def set_clock(house, seconds):
    """In place: those who look at it have the file in their memory."""
    with open(house.clock, "r+b" if house.clock.exists() else "xb", buffering=0) as file:
        file.write(struct.pack("<q", seconds))


def with_clock(house):
    """One worker whose clock can be set; on SQLite there is no clock but the machine's, so that all have it."""
    house.clock = pathlib.Path(house.directory, "clock")
    set_clock(house, 0)
    shim = pathlib.Path(house.build, "tests/drill/clock.so")
    house.shim = {"LD_PRELOAD": str(shim), "DRILL_CLOCK": str(house.clock)}
    everybody = house.place.name == "sqlite"
    house.start("api", environment=house.shim if everybody else None)
    house.start("worker", environment=house.shim if everybody else None)
    house.start("worker", environment=house.shim)


def clock_wrong(house):
    """The clock is an hour early or late, and jumps while parts are computed."""
    jobs = several(house)
    house.nap(0, 0.3)
    set_clock(house, house.random.choice((-3600, 0, 3600)))
    jobs += [house.submit("walk")]
    house.finish(jobs)
