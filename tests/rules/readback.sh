#!/bin/bash
# Reads answers in every representation with the programs that people use, and compares them with the JSON to the last bit.
# usage: readback.sh BUILD     (build/release, for the server)
# Leaves to others: the comparison (readback.py).
# Invariant: programs that are not installed are reported as skipped.
cd "$(dirname "$0")/../.." || exit
# shellcheck source=tests/rules/npm.sh
. tests/rules/npm.sh
fetch_packages tests/rules build/spectral
fetch_packages tests/rules/readers build/readers
exec /usr/bin/python3 -B tests/rules/readback.py "$1"
