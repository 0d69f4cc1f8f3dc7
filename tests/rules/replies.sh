#!/bin/bash
# Holds every reply that the wire tests saw against api/call/openapi.yaml, and shows first that wrong replies are noticed.
# usage: replies.sh FILE     (build/release/tests/wire/replies.ndjson)
# Leaves to others: the comparison (replies.py).
# Invariant: an operation, or an error of the document, that no test reached fails.
set -u
cd "$(dirname "$0")/../.." || exit
python=/usr/bin/python3
wrong=$(wc -l <tests/rules/replies_bad.ndjson)
noticed=$($python tests/rules/replies.py api/call/openapi.yaml tests/rules/replies_bad.ndjson | tail -n 1)
if [ "$noticed" != "0 passed, $wrong failed" ]; then
    echo "FAIL of $wrong wrong replies: $noticed"
    echo '0 passed, 1 failed'
    exit 1
fi
exec $python tests/rules/replies.py --complete api/call/openapi.yaml "$1"
