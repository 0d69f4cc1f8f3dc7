#!/bin/bash
# What operators are given, tried: alert rules and dashboard against a live server, a backup that is taken while jobs run and restored.
# usage: operators.sh BUILD     (build/release, for the server)
# Leaves to others: the checks (operators.py).
# Invariant: without promtool or PostgreSQL what needs them is skipped aloud.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/operators.py "$1"
