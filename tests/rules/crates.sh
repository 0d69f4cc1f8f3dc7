#!/bin/bash
# Opens crates of jobs with readers of other makers, holds their metadata against RO-Crate 1.1, and proves their bits by --replay.
# usage: crates.sh BUILD     (build/release, for the server)
# Leaves to others: the checks (crates.py).
# Invariant: a reader that is not installed is skipped aloud.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/crates.py "$1"
