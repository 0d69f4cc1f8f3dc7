#!/bin/bash
# Checks the page's scripts without a browser: types (tsc --checkJs), lengths and branching (eslint), layout (prettier).
# usage: types.sh [--format]     (--format: formats the scripts instead)
# Leaves to others: the behaviour of the page (web.sh), the C sources (layout.sh).
# Invariant: fetched files are in build/; only --format changes a file.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/webtest
skip() { echo "skip types: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

# shellcheck source=tests/rules/npm.sh
. tests/rules/npm.sh
command -v npm >/dev/null || skip 'npm is not here (make lint installs it)'
fetch_packages tests/web $home || skip 'npm cannot fetch tsc, eslint and prettier'
tool() { "$home/node_modules/.bin/$1" "${@:2}"; }
layout() { tool prettier --config tests/web/prettier.json --log-level warn "$1" 'server/web/**/*.{js,d.ts}' '!**/node_modules/**'; }

if [ "${1:-}" = --format ]; then
    layout --write
    exit
fi
passed=0 failed=0
check() { # what, then a command
    if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; fi
}
check 'every name has the type that it is used with' tool tsc --project tests/web/tsconfig.json --pretty false
check 'functions and files are short, and branch little' tool eslint --config tests/web/eslint.config.mjs server/web tests/web
check 'the scripts are laid out by prettier (tests/rules/types.sh --format)' layout --check
echo "$passed passed, $failed failed"
[ $failed = 0 ]
