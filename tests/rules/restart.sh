#!/bin/bash
# Restarts two api and two worker processes one after the other behind the shipped nginx, under load, on PostgreSQL.
# usage: restart.sh BUILD     (build/release, for the server)
# Leaves to others: the load and the count (restart.py).
# Invariant: a program that is not installed is skipped aloud; what was started ends.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/restart.py "$1"
