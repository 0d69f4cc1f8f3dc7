"""Histories of jobs under failover: two real servers of PostgreSQL, one the other's standby; again and again the first is killed,
the second promoted, and the first made anew as its standby, while clients submit, look, list and fetch. Then the history is checked.

usage: histories.py BUILD [--rounds N] [--seed S] [--keep]      (make histories; by default 10 rounds each)
With synchronous replication nothing that was acknowledged may be lost, done twice, told in another way or told to have gone back.
With asynchronous replication what the standby had not yet got is lost: how much is told, and that no result has a wrong bit must hold.

Leaves to others: what a history may be (history.py), daemons (house.py), one server of PostgreSQL (places.py), the line (proxy.py).
Invariant: traffic stays on loopback and Unix sockets; what was started ends; every server is killed with all of its processes.
"""
import argparse
import collections
import contextlib
import http.client
import json
import os
import pathlib
import random
import shutil
import signal
import sys
import tempfile
import threading
import time

import history
from house import OCTETS, PATIENCE, Daemon, flips, undisturbed, walk
from places import Postgres, postgres_programs
from proxy import Proxy

CLIENTS, READERS = 4, 3
OPEN = 3  # jobs that a client has at most: a machine that is busy otherwise is not to heap them up
KINDS = {"map": ("/v1/ensembles", flips(8, 20, 5)), "walk": ("/v1/trajectories", walk(30, 201))}


class Server(Postgres):
    """One of the two; begins as a first one, and can be made anew as the other's standby."""

    def processes(self):
        tree = pathlib.Path(f"/proc/{self.server.pid}/task/{self.server.pid}/children")
        with contextlib.suppress(OSError):
            return [self.server.pid, *map(int, tree.read_text().split())]
        return [self.server.pid]

    def die(self):
        """As when its machine loses power: no process of it says another word."""
        self.server.send_signal(signal.SIGSTOP)  # it begins no other
        for pid in reversed(self.processes()):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.server.wait()

    def follow(self, other, line):
        """Forgets all, and begins anew as a standby, by a line to the other."""
        data = pathlib.Path(self.directory, "data")
        shutil.rmtree(data)
        self.run("pg_basebackup", "-D", "data", "-d", other.url, "-X", "stream", "-c", "fast", "-N")
        own = os.stat(data)
        for name, text in (("postgresql.auto.conf", f"primary_conninfo = 'host=127.0.0.1 port={line.port} user=pendulumd sslmode=disable gssencmode=disable'\n"),
                           ("standby.signal", "")):
            (data / name).write_text(text)
            os.chown(data / name, own.st_uid, own.st_gid)
        self.start()


class Pair:
    """The first and its standby."""

    def __init__(self, directory, synchronous):
        self.synchronous, self.line = synchronous, None
        self.servers = []
        for name in ("a", "b"):
            os.mkdir(directory / name)
            self.servers.append(Server(directory / name))
        self.first, self.second = self.servers
        hosts = ",".join(server.directory for server in self.servers)
        self.url = f"postgresql://pendulumd@/postgres?host={hosts}&target_session_attrs=read-write"
        self.second.die()
        self.join()

    def wait(self, what, command):
        end = time.monotonic() + PATIENCE
        while self.first.rows(command) != [["t"]]:
            if time.monotonic() > end:
                raise RuntimeError(f"{what}: see {self.first.log.name}")
            time.sleep(0.02)

    def join(self):
        """The second follows the first; with synchronous replication nothing is acknowledged from now on that it does not have."""
        self.line = Proxy(self.first.socket)
        self.second.follow(self.first, self.line)
        if self.synchronous:
            self.first.rows("ALTER SYSTEM SET synchronous_standby_names = '*'")
            self.first.rows("SELECT pg_reload_conf()")
        self.wait("the standby does not come", f"SELECT count(*) = 1 FROM pg_stat_replication WHERE sync_state = '{'sync' if self.synchronous else 'async'}'")
        self.level()

    def level(self):
        """Waits until the standby has what the first has now."""
        place = self.first.rows("SELECT pg_current_wal_lsn()")[0][0]
        self.wait("the standby lags", f"SELECT bool_and(flush_lsn >= '{place}') FROM pg_stat_replication")

    def fail(self, silence):
        """The line falls silent, the first dies, the second takes its place."""
        if silence:
            self.line.freeze()
            time.sleep(silence)
        self.first.die()
        self.line.close()
        self.first, self.second = self.second, self.first
        self.first.rows("SELECT pg_promote()")
        self.wait("the standby is not promoted", "SELECT NOT pg_is_in_recovery()")

    def close(self):
        if self.line:
            self.line.close()
        for server in self.servers:
            if server.server.poll() is None:
                server.die()
            server.log.close()


class Crowd:
    """Clients that submit until they are told to stop, and readers that look at what was accepted."""

    def __init__(self, daemons, seed):
        self.daemons, self.past, self.over, self.seed = daemons, history.History(), threading.Event(), seed
        self.told, self.lock = collections.defaultdict(list), threading.Lock()  # of a client: ids, keys and requests
        self.threads = [threading.Thread(target=self.keep, args=(work, name, random.Random(f"{seed}{work}{name}")))
                        for work, count in ((self.submit, CLIENTS), (self.read, READERS)) for name in range(count)]
        self.broken = []
        for thread in self.threads:
            thread.start()

    def keep(self, work, name, chance):
        try:
            work(f"client-{name % CLIENTS}", chance)
        except Exception as error:  # told with the history
            self.broken.append(f"{work.__name__}: {error!r}")

    def question(self, chance, client, method, path, body=None, **headers):
        """One question to one of the daemons, and no second try: status, fields, bytes; 0 where there was no answer."""
        try:
            return chance.choice(self.daemons).ask(method, path, body, {"Authorization": f"Bearer secret-of-{client}-{self.seed}"} | headers, 60)
        except (OSError, http.client.HTTPException):
            return 0, {}, b""

    # --- those that submit

    def post(self, chance, client, key, kind):
        path, body = KINDS[kind]
        status, fields, text = self.question(chance, client, "POST", path, body, Prefer="respond-async", **{"Idempotency-Key": key})
        return status, fields["Location"].split("/")[3] if status in (202, 303) else text

    def submit(self, client, chance):
        """Asks with a key until it is acknowledged, and sometimes once more, or with another request."""
        number, waits = 0, []
        while not self.over.is_set():
            while len(waits) >= OPEN and not self.over.is_set():
                event = self.past.ask("job", client, waits[0], lambda: self.job(chance, client, waits[0]))
                if event.status == 404 or (event.status == 200 and event.told[0] in history.OVER):
                    waits.pop(0)
                else:
                    time.sleep(0.05)
            number += 1
            key, kind = f"key-{number}", chance.choice(list(KINDS))
            event, end = None, time.monotonic() + PATIENCE
            while (not event or event.status not in (202, 303)) and time.monotonic() < end:
                event = self.past.ask("submit", client, (key, kind), lambda: self.post(chance, client, key, kind))
                if event.status not in (202, 303):
                    time.sleep(0.02)
            with self.lock:
                self.told[client].append((event.told, key, kind))
            waits.append(event.told)
            again = chance.random()
            if again < 0.3:
                self.past.ask("submit", client, (key, kind), lambda: self.post(chance, client, key, kind))
            elif again < 0.4:
                other = next(name for name in KINDS if name != kind)
                self.past.ask("other", client, (key, other), lambda: self.post(chance, client, key, other))
            time.sleep(chance.uniform(0, 0.15))

    # --- those that read

    def job(self, chance, client, job):
        status, _, text = self.question(chance, client, "GET", f"/v1/jobs/{job}")
        view = json.loads(text) if status == 200 else {}
        return status, (view["status"], view["parts"]["done"]) if view else text

    def results(self, chance, client, job):
        status, _, data = self.question(chance, client, "GET", f"/v1/jobs/{job}/results", Accept=OCTETS)
        return status, data

    def list(self, chance, client):
        """All pages; a page that does not come leaves the list without an answer."""
        path, found = "/v1/jobs?limit=100", {}
        while path:
            status, _, text = self.question(chance, client, "GET", path)
            if status != 200:
                return status, text
            page = json.loads(text)
            found |= {job["id"]: (job["status"], job["parts"]["done"]) for job in page["jobs"]}
            path = next((link["href"] for link in page["links"] if link["rel"] == "next"), None)
        return 200, found

    def read(self, client, chance):
        while not self.over.is_set():
            with self.lock:
                client = chance.choice(list(self.told) or [client])
                job = chance.choice(self.told[client] or [None])
            kind = chance.random()
            if job and kind < 0.6:
                self.past.ask("job", client, job[0], lambda: self.job(chance, client, job[0]))
            elif job and kind < 0.8:
                self.past.ask("results", client, job[0], lambda: self.results(chance, client, job[0]))
            else:
                self.past.ask("list", client, None, lambda: self.list(chance, client))
            time.sleep(chance.uniform(0, 0.03))

    # --- the end

    def stop(self):
        self.over.set()
        for thread in self.threads:
            thread.join()

    def settle(self):
        """Every job ends, and is fetched; what is away is waited for, what is lost is not. How many ended."""
        chance, ended = random.Random(self.seed), 0
        for client, job in [(client, job) for client, jobs in self.told.items() for job, _, _ in jobs]:
            end = time.monotonic() + PATIENCE
            while time.monotonic() < end:
                event = self.past.ask("job", client, job, lambda: self.job(chance, client, job))
                if event.status == 404 or (event.status == 200 and event.told[0] in history.OVER):
                    break
                time.sleep(0.02)
            event = self.past.ask("results", client, job, lambda: self.results(chance, client, job))
            ended += event.status == 200
        for client in self.told:
            self.past.ask("list", client, None, lambda: self.list(chance, client))
        return ended


def twice(pair):
    """Parts that were marked as done more than once."""
    rows = pair.first.rows("SELECT job, number, COUNT(*) FROM drill_kept GROUP BY job, number HAVING COUNT(*) > 1")
    return [("done twice", f"part {number} of {job}: {count} times") for job, number, count in rows]


def live(build, directory, synchronous, rounds, chance, right):
    """Some rounds of one kind of replication: what is told, and the faults."""
    pair = Pair(directory, synchronous)
    daemons = []
    try:
        for _ in range(2):
            daemons.append(Daemon(build, pair.url, "all", directory, ("--job-part-seconds", "0.005", "--job-lease-seconds", "2", "--keep-seconds", "86400")))
        pair.first.watch()
        pair.level()
        crowd = Crowd(daemons, chance.randrange(1 << 30))
        try:
            for _ in range(rounds):
                time.sleep(chance.uniform(0.5, 1.5))
                pair.fail(chance.choice((0, chance.uniform(0, 0.6))))
                time.sleep(chance.uniform(0, 1))
                pair.join()
        finally:
            crowd.stop()
        ended = crowd.settle()
        events = crowd.past.events
        faults = history.check(events, right) + twice(pair) + [("broken", text) for text in crowd.broken]
        faults += [("gone", f"a daemon ended: {daemon.log.read_text()[-300:]}") for daemon in daemons if daemon.process.poll() is not None]
        answered = collections.Counter(event.kind for event in events if event.status not in (0, 503))
        silent = sum(event.status in (0, 503) for event in events)
        jobs = sum(map(len, crowd.told.values()))
        return f"{rounds} failovers, {jobs} jobs acknowledged, {ended} fetched; answered: {dict(answered)}, {silent} times nobody or 503", jobs, ended, faults
    finally:
        for daemon in daemons:
            daemon.kill()
        pair.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 1000000)
    parser.add_argument("--keep", action="store_true", help="leaves the stores and logs for a look")
    asked = parser.parse_args()
    wrong = history.sound()
    counts = [not wrong, bool(wrong)]
    print("".join(f"FAIL {text}\n" for text in wrong), end="")
    if not postgres_programs():
        print(f"skip histories: PostgreSQL is not installed\n{counts[0]} passed, {counts[1]} failed, 2 skipped")
        sys.exit(counts[1])
    chance, directory = random.Random(asked.seed), pathlib.Path(tempfile.mkdtemp(prefix="pendulumd-histories-"))
    directory.chmod(0o711)
    try:
        right = undisturbed(asked.build.resolve(), directory, KINDS)
        for synchronous in (True, False):
            place = directory / ("synchronous" if synchronous else "asynchronous")
            place.mkdir()
            place.chmod(0o711)
            told, jobs, ended, faults = live(asked.build.resolve(), place, synchronous, asked.rounds, chance, right)
            kinds = collections.Counter(kind for kind, _ in faults)
            bad = [fault for fault in faults if synchronous or fault[0] in ("bits", "strange", "broken", "gone", "done twice")]
            good = not bad and jobs > asked.rounds and ended and (not synchronous or ended == jobs)
            print(f"{'ok  ' if good else 'FAIL'} {place.name}: {told}; " + (", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "no fault"), flush=True)
            if not good:
                print("".join(f"       {kind}: {text}\n" for kind, text in bad[:20]) + f"       seed {asked.seed}")
            counts[0] += good
            counts[1] += not good
    finally:
        if not asked.keep:
            shutil.rmtree(directory, ignore_errors=True)
    print(f"{counts[0]} passed, {counts[1]} failed")
    sys.exit(counts[1] > 0)


if __name__ == "__main__":
    main()
