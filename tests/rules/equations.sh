#!/bin/bash
# Runs what /v1/equations writes: its programs with NumPy and Octave, its formulas through KaTeX, and compares both with /v1/forces.
# usage: equations.sh BUILD     (build/release, for the server)
# Leaves to others: the comparison (equations.py).
# Invariant: a program that is not installed is skipped aloud.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/equations.py "$1"
