"""A PostgreSQL of a test's own, for tests in other languages: says its URL, restarts when it is told to, and ends when its input does.

usage: store.py        (then a line "restart" or "crash", each of which is answered by "back" once it is there again)
Leaves to others: what is kept there. Invariant: it does not outlive whoever started it.
"""
import signal
import sys

from places import place, postgres_programs

if not postgres_programs():
    sys.exit("PostgreSQL is not installed")
with place("postgres") as store:
    print(store.url, flush=True)
    for line in sys.stdin:
        store.restart(signal.SIGQUIT if line.strip() == "crash" else signal.SIGINT)
        print("back", flush=True)
