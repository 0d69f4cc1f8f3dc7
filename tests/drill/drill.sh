#!/bin/bash
# A few rounds of every fault of the crash drill, in a minute.
# usage: drill.sh BUILD     (build/release, for the server)
# Leaves to others: the drill (drill.py).
# Invariant: a store or a fault that cannot be had here is skipped aloud.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/drill/drill.py "$1" --rounds 2 --seconds 4
