#!/bin/bash
# Starts the server on a free port and posts every example of api/call/openapi.yaml to it.
# usage: examples.sh BUILD     (build/release, for the server)
# Leaves to others: the comparison (examples.py); whether the examples obey their own schemas (openapi.sh).
# Invariant: the server that it started ends with it.
set -u
export PENDULUMD_ALLOW_ROOT=on
cd "$(dirname "$0")/../.." || exit
home=$(mktemp -d)
log=$home/log
"$1/pendulumd" --listen 127.0.0.1:0 --store "sqlite:$home/store.db" >/dev/null 2>"$log" &
server=$!
trap 'kill $server 2>/dev/null; wait $server; rm -rf "$home"' EXIT
for _ in $(seq 1200); do
    url=$(sed -n 's/^listening on //p' "$log")
    [ -z "$url" ] || break
    sleep 0.1
done
if [ -z "$url" ]; then
    cat "$log"
    echo 'FAIL the server did not start'
    echo '0 passed, 1 failed'
    exit 1
fi
/usr/bin/python3 tests/rules/examples.py api/call/openapi.yaml "$url"
