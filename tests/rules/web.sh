#!/bin/bash
# Drives the page with a real browser, where chromium and npm are here and npm can fetch what drives it.
# usage: web.sh BUILD [--bench] [NAME]     (build/release, for the server; a part of a test's name; --bench: measures instead)
# Leaves to others: the tests (tests/web).
# Invariant: what npm fetches lies in build/; pictures of every view are left in build/check/web.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/webtest
skip() { echo "skip web: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

command -v "${CHROMIUM:-/usr/bin/chromium}" >/dev/null || skip 'chromium is not here'
command -v npm >/dev/null || skip 'npm is not here'
if ! cmp -s tests/web/package-lock.json $home/package-lock.json || [ ! -d $home/node_modules/playwright-core ]; then
    rm -rf $home.new && mkdir -p $home.new && cp tests/web/package.json tests/web/package-lock.json $home.new
    timeout 240 npm ci --ignore-scripts --prefix $home.new --cache build/npm --no-audit --no-fund --no-update-notifier --silent \
        >/dev/null 2>&1 || skip 'npm cannot fetch what drives the browser'
    rm -rf $home && mv $home.new $home
fi
PENDULUMD=$PWD/$1/pendulumd exec node tests/web/run.mjs "${@:2}"
