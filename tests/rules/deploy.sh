#!/bin/bash
# Checks the files that put pendulumd on several processes, and runs what compose.yaml describes, on loopback.
# usage: deploy.sh BUILD     (build/release, for the server)
# Leaves to others: the checks (deploy.py), containers (image.sh).
# Invariant: a program that is not installed is skipped aloud; what was started ends.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/deploy.py "$1"
