"""The crash drill: every fault so many times on every store, then the account: jobs accepted, lost, done twice, wrong.

usage: drill.py BUILD [--rounds N] [--seconds S] [--keep] [PART-OF-A-NAME...]
A line for each fault and store; below a bad one, what is wrong. It fails when an accepted job is lost, an effect is
there twice, or a bit differs from an undisturbed answer. --seconds bounds the time in which rounds are begun.

Leaves to others: the faults (faults.py), daemons and the account (house.py), databases (places.py).
Invariant: traffic stays on loopback and Unix sockets; what was started ends; only processes of the drill are hurt.
"""
import argparse
import concurrent.futures
import os
import pathlib
import random
import shutil
import sys
import tempfile
import time
import traceback

import faults
from house import JOBS, VARIOUS, House, undisturbed
from places import place, postgres_programs

BOTH = ("sqlite", "postgres")
SPLIT = ("api", "worker", "worker")

# name: what is done in a round, on which stores, with which processes, what is done before and after, what is told
FAULTS = {
    "worker-killed": (faults.worker_killed, BOTH, SPLIT, None, None, None),
    "crowd-killed": (faults.crowd_killed, ("postgres",), ("api",) + ("worker",) * 64, None, None, None),
    "all-killed": (faults.all_killed, BOTH, SPLIT, None, None, None),
    "daemon-killed": (faults.daemon_killed, BOTH, ("all",), None, None, None),
    "worker-stopped": (faults.worker_stopped, BOTH, SPLIT, None, None, None),
    "poison": (faults.poison, BOTH, ("api", "worker"), faults.in_one_part, None, None),
    "database-restarted": (faults.database_restarted, ("postgres",), SPLIT, None, None, None),
    "connections-cut": (faults.connections_cut, ("postgres",), SPLIT, faults.through_proxies, None, None),
    "connections-swallowed": (faults.connections_swallowed, ("postgres",), SPLIT, faults.through_proxies_timed, None, faults.tell_silence),
    "doubled": (faults.doubled, BOTH, ("api", "api", "worker"), None, None, None),
    "cancelled": (faults.cancelled, BOTH, SPLIT, faults.note_times, None, faults.tell_times),
    "disk-full": (faults.disk_full, BOTH, SPLIT, faults.on_small_disk, faults.off_small_disk, None),
    "erased-when-full": (faults.erased_when_full, BOTH, SPLIT, faults.on_small_disk, faults.off_small_disk, None),
    "files-robbed": (faults.files_robbed, ("postgres",), ("api",) + ("worker",) * 64, faults.in_files, faults.off_small_disk, None),
    "clock-wrong": (faults.clock_wrong, BOTH, (), faults.with_clock, None, None),
}


def rounds(house, fault, count, seconds):
    """Runs rounds of one fault; how many."""
    run, _, roles, begin, _, _ = fault
    done, end = 0, time.monotonic() + seconds
    if begin:
        begin(house)
    for role in roles:
        house.start(role)
    house.place.watch()
    while done < count and (not done or time.monotonic() < end):
        run(house)
        done += 1
    return done


def drill(build, name, kind, count, seconds, seed, right, keep):
    """One fault on one store: passed, failed, skipped, and the lines that tell."""
    title, begin = f"{name} ({kind})", time.monotonic()
    _, _, _, _, after, tell = fault = FAULTS[name]
    directory = tempfile.mkdtemp(prefix="pendulumd-drill-")
    try:
        with place(kind, keep) as store:
            house = House(build, store, random.Random(seed), directory, right)
            try:
                done = rounds(house, fault, count, seconds)
                house.settle()
                accepted, lost, twice, wrong, complaints = house.account()
            finally:
                house.close()
                if after:
                    after(house)
    except faults.Skip as why:
        return 0, 0, 1, f"skip {title}: {why}"
    except Exception:
        return 0, 1, 0, f"FAIL {title}, seed {seed}:\n{traceback.format_exc()}"
    finally:
        if not keep:
            shutil.rmtree(directory, ignore_errors=True)
    more = "".join(f", {value} {what}" for what, value in house.notes.items())
    if tell and tell(house):
        more += f", {tell(house)}"
    bad = bool(lost or twice or wrong)
    line = (f"{'FAIL' if bad else 'ok  '} {title:<34} {done:4d} rounds  {accepted:5d} accepted  {lost} lost  {twice} twice  {wrong} wrong"
            f"  ({time.monotonic() - begin:.1f} s{more})")
    return int(not bad), int(bad), 0, "\n".join([line] + [f"       {text}" for text in complaints[:20]] + ([f"       seed {seed}"] if bad else []))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--rounds", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 1000000)
    parser.add_argument("--keep", action="store_true", help="leaves the stores and logs for a look")
    asked = parser.parse_intermixed_args()
    build = asked.build.resolve()
    counts = [0, 0, 0]
    with tempfile.TemporaryDirectory(prefix="pendulumd-drill-") as directory:
        right = undisturbed(build, directory, JOBS | VARIOUS)
    print(f"undisturbed: {', '.join(f'{kind} {len(data)} bytes' for kind, data in right.items())}; seed {asked.seed}", flush=True)
    # most of a round is waiting for a lease to end, so drills stand side by side, each in a process of its own
    with concurrent.futures.ProcessPoolExecutor(2 * (os.cpu_count() or 1)) as pool:
        running = []
        for name, (_, stores, *_) in FAULTS.items():
            for kind in stores:
                if asked.names and not any(part in f"{name} ({kind})" for part in asked.names):
                    continue
                if kind == "postgres" and not postgres_programs():
                    counts[2] += 1
                    print(f"skip {name} (postgres): PostgreSQL is not installed")
                    continue
                running.append(pool.submit(drill, build, name, kind, asked.rounds, asked.seconds, asked.seed, right, asked.keep))
        for done in concurrent.futures.as_completed(running):
            *count, lines = done.result()
            counts = [total + more for total, more in zip(counts, count)]
            print(lines, flush=True)
    print(f"{counts[0]} passed, {counts[1]} failed" + (f", {counts[2]} skipped" if counts[2] else ""))
    sys.exit(counts[1] > 0 or not counts[0])


if __name__ == "__main__":
    main()
