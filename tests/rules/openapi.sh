#!/bin/bash
# Lints api/call/openapi.yaml with spectral (package.json), where npm is here and can fetch it.
# Leaves to others: whether the document tells the truth (docs.sh, replies.sh).
# Invariant: spectral and its cache live in build/; errors and warnings fail.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/spectral
skip() { echo "skip openapi: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

command -v npm >/dev/null || skip 'npm is not here (make lint installs it)'
if ! cmp -s tests/rules/package-lock.json $home/package-lock.json || [ ! -x $home/node_modules/.bin/spectral ]; then
    rm -rf $home.new && mkdir -p $home.new && cp tests/rules/package.json tests/rules/package-lock.json $home.new
    timeout 240 npm ci --ignore-scripts --prefix $home.new --cache build/npm --no-audit --no-fund --no-update-notifier --silent \
        >/dev/null 2>&1 || skip 'npm cannot fetch spectral'
    rm -rf $home && mv $home.new $home
fi
if $home/node_modules/.bin/spectral lint --fail-severity=warn --ruleset tests/rules/.spectral.yaml api/call/openapi.yaml; then
    echo '1 passed, 0 failed'
else
    echo '0 passed, 1 failed'
    exit 1
fi
