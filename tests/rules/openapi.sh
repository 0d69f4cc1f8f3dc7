#!/bin/bash
# Lints api/call/openapi.yaml with spectral (package.json), where npm is here and can fetch it.
# Leaves to others: whether the document tells the truth (docs.sh, replies.sh).
# Invariant: spectral and its cache live in build/; errors and warnings fail.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/spectral
skip() { echo "skip openapi: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

# shellcheck source=tests/rules/npm.sh
. tests/rules/npm.sh
command -v npm >/dev/null || skip 'npm is not here (make lint installs it)'
fetch_packages tests/rules $home || skip 'npm cannot fetch spectral'
if $home/node_modules/.bin/spectral lint --fail-severity=warn --ruleset tests/rules/.spectral.yaml api/call/openapi.yaml; then
    echo '1 passed, 0 failed'
else
    echo '0 passed, 1 failed'
    exit 1
fi
