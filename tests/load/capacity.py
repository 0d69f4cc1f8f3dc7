"""How much a house on PostgreSQL carries: what a request, a job, a member and a megabyte of results cost each of its parts in processor
time, what that foretells of a mixed load, and how much of it comes true.

usage: capacity.py BUILD [SECONDS of a mixed load, 10] [ROUNDS, 3]
Leaves to others: peers and rows (load.py), latencies (jobs.py), rooms (classes.py). Invariant: all figures are processor time, and
each round measures the constants and then a mixed load, so that what else the machine does changes both alike.
"""
import pathlib
import sys
import tempfile
import threading
import time

from jobs import ASYNC, DOUBLE, LITTLE, database, house, seconds_of, until_done
from servers import client, message

BUILD, SECONDS = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
ROUNDS = int(sys.argv[3]) if len(sys.argv) > 3 else 3
UNITS = ("a motion of 501 instants", "a small job", "a member", "a megabyte of results")
OPTIONS = ("--max-client-jobs", "1000000", "--max-client-queue", "1000", "--cache-bytes", "0")
ROLES = (("api", 1), ("worker", 1))
PARTS = ("answering", "computing jobs", "PostgreSQL")
SIDE = 200
MOTION = f'{{{DOUBLE},"initial":{{"theta":[2,2.5]}},"times":{{"stop":5,"count":501}}}}'
AXES = ",".join(f'{{"vary":"theta","arm":{arm},"start":-3,"stop":3,"count":{SIDE}}}' for arm in (1, 2))
FLIPS = f'{{{DOUBLE},"duration":20,"rtol":1e-9,"atol":1e-9,"observables":["first_flip"],"grid":[{AXES}]}}'
BYTES = SIDE * SIDE * 4 * 8  # of its results: number, time, arm and state of each member


class House:
    """The processes, and what each part of the house has used of processors so far."""

    def __init__(self, store, daemons):
        self.store, self.daemons, self.api = store, daemons, daemons[0]

    def used(self):
        return [*(seconds_of([daemon.process.pid]) for daemon in self.daemons), seconds_of(database(self.store))]

    def submit(self, path, body):
        status, headers, text = self.api.ask("POST", path, body, ASYNC)
        assert status == 202, text
        return headers["Location"]

    def done(self, location):
        view = until_done(self.api, location)
        assert view["status"] == "successful", view
        return location

    def download(self, location):
        status, _, data = self.api.ask("GET", location + "/results", None, {"Accept": "application/octet-stream"}, seconds=60)
        assert status == 200 and len(data) == BYTES, (status, len(data))

    def small_jobs(self, count):
        """Waits for them by one look at the last: what looks cost is no part of a job."""
        places = [self.submit("/v1/forces", LITTLE) for _ in range(count)]
        time.sleep(0.5)
        for location in places[-1:]:
            self.done(location)
        return count

    def flips(self):
        return self.done(self.submit("/v1/ensembles", FLIPS))

    def requests(self, directory, seconds, connections=4):
        """Answers of the client program, which is a process of its own."""
        file = pathlib.Path(directory, "motion.http")
        file.write_bytes(message("/v1/trajectories", MOTION))
        figures = client(BUILD, self.api, [f"{file}=200"], "--connections", str(connections), seconds=seconds)
        assert not figures["wrong"] and not figures["broken"], figures
        return figures["rate"] * seconds


def constants(home, directory, known):
    """Adds what each kind of work used of each part, and how many units of it there were."""
    location = home.flips()
    works = (lambda: home.requests(directory, 3), lambda: home.small_jobs(200), lambda: [home.flips() for _ in range(4)] and 4 * SIDE * SIDE,
             lambda: [home.download(location) for _ in range(60)] and 60 * BYTES / 1e6)
    for name, work in zip(UNITS, works):
        before = home.used()
        count = work()
        known[name][0] += count
        for part, (after, was) in enumerate(zip(home.used(), before)):
            known[name][1][part] += after - was


def mixed(home, directory):
    """All kinds at once, by clients that wait for their answers; how many units of each there were."""
    units, end = dict.fromkeys(UNITS, 0), time.monotonic() + SECONDS

    def jobs():
        while time.monotonic() < end:
            units["a small job"] += home.small_jobs(20)

    def members():
        while time.monotonic() < end:
            location = home.flips()
            home.download(location)
            units["a member"] += SIDE * SIDE
            units["a megabyte of results"] += BYTES / 1e6

    def requests():
        units["a motion of 501 instants"] += home.requests(directory, SECONDS, 1)
    threads = [threading.Thread(target=work) for work in (jobs, members, requests)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return units


def main():
    known, units, used = {name: [0, [0.0] * len(PARTS)] for name in UNITS}, dict.fromkeys(UNITS, 0), [0.0] * len(PARTS)
    with tempfile.TemporaryDirectory() as directory, house(BUILD, "postgres", ROLES, *OPTIONS) as (store, daemons):
        home = House(store, daemons)
        home.small_jobs(20)
        home.download(home.flips())
        for _ in range(ROUNDS):
            constants(home, directory, known)
            before = home.used()
            units = {name: units[name] + count for name, count in mixed(home, directory).items()}
            used = [was + after - begin for was, after, begin in zip(used, home.used(), before)]
    print(f"{'processor time, microseconds':34}", *(f"{part:>16}" for part in PARTS))
    costs = {name: [time / count for time in times] for name, (count, times) in known.items()}
    for name, each in costs.items():
        print(f"{name:34}", *(f"{1e6 * cost:16.2f}" for cost in each))
    told = [sum(costs[name][part] * count for name, count in units.items()) for part in range(len(PARTS))]
    print("a mixed load of", ", ".join(f"{count:.0f} times {name}" for name, count in units.items()))
    for title, row in (("s of processors, foretold", told), ("s of processors, used", used)):
        print(f"{title:34}", *(f"{x:16.2f}" for x in row), f"{sum(row):10.2f}")
    print(f"{'used / foretold':34}", *(f"{x / y:16.2f}" for x, y in zip(used, told)), f"{sum(used) / sum(told):10.2f}")


main()
