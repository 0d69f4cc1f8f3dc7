#!/bin/bash
# Runs the clients of api/clients against a live server, and compares what they bring with each other to the last bit.
# usage: clients.sh BUILD [NAME...]     (build/release, for the server; names: which clients)
# Leaves to others: what each client is asked (clients.py, tests/clients).
# Invariant: a client whose language is not installed is skipped aloud.
cd "$(dirname "$0")/../.." || exit
exec /usr/bin/python3 -B tests/rules/clients.py "$@"
