#!/bin/bash
# Tests the page with a real browser, if chromium and npm are here and npm can fetch the browser's driver.
# usage: web.sh BUILD [--bench] [NAME]     (build/release, for the server; a part of a test's name; --bench: measures instead)
#        BROWSER=firefox web.sh BUILD [NAME]     (the same tests in Firefox, except those that need Chromium's own protocol)
#        web.sh BUILD --lesson [PUPILS [STORE]]     (a lesson in real pages)
#        web.sh BUILD --pictures [NAME]     (makes the pictures of the guides)
# Leaves to others: the tests (tests/web).
# Invariant: fetched files are in build/; pictures of every view are left in build/check/web.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/webtest
skip() { echo "skip web: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

if [ "${BROWSER:-}" = firefox ]; then
  command -v "${FIREFOX:-/usr/bin/firefox-esr}" >/dev/null || skip 'firefox is not here'
else
  command -v "${CHROMIUM:-/usr/bin/chromium}" >/dev/null || skip 'chromium is not here'
fi
# shellcheck source=tests/rules/npm.sh
. tests/rules/npm.sh
command -v npm >/dev/null || skip 'npm is not here'
fetch_packages tests/web $home || skip 'npm cannot fetch what drives the browser'
exec 8>&- # what npm has brought stays: a second run need not wait for this one
export PENDULUMD=$PWD/$1/pendulumd
[ "${2:-}" != --pictures ] || exec node tests/web/pictures.mjs "${@:3}"
[ "${2:-}" != --lesson ] || exec node tests/web/lesson.mjs "${@:3}"
exec node tests/web/run.mjs "${@:2}"
