#!/bin/bash
# Puts a real nginx with docker/nginx.conf before the daemon, on loopback, and asks through it.
# usage: nginx.sh BUILD     (build/release, for the server)
# Leaves to others: the comparison (nginx.py), containers (image.sh).
# Invariant: a program that is not installed is skipped aloud; what was started ends.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/nginx.py "$1"
