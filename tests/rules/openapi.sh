#!/bin/bash
# Lints api/openapi.yaml with spectral, where npm is here and can fetch it.
# Leaves to others: whether the document tells the truth (docs.sh, replies.py).
# Invariant: spectral and its cache live in build/; errors and warnings fail.
set -u
cd "$(dirname "$0")/../.." || exit
version=6.16.3
home=build/spectral-$version
skip() { echo "skip openapi: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

command -v npm >/dev/null || skip 'npm is not here (make lint installs it)'
if [ ! -x $home/node_modules/.bin/spectral ]; then
    timeout 240 npm install --prefix $home.new --cache build/npm --no-audit --no-fund --no-update-notifier --silent \
        @stoplight/spectral-cli@$version >/dev/null 2>&1 || skip "npm cannot fetch spectral $version"
    rm -rf $home && mv $home.new $home
fi
if $home/node_modules/.bin/spectral lint --fail-severity=warn --ruleset tests/rules/spectral.yaml api/openapi.yaml; then
    echo '1 passed, 0 failed'
else
    echo '0 passed, 1 failed'
    exit 1
fi
