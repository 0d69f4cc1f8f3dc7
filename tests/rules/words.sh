#!/bin/bash
# Checks the words of the page, without a browser: every language says all, and nothing that the page does not show.
# usage: words.sh
# Leaves to others: what is checked (tests/web/words.mjs), whether a page shows bare keys (tests/web/test_language.mjs).
# Invariant: nothing is fetched and nothing is written.
set -u
cd "$(dirname "$0")/../.." || exit
command -v node >/dev/null || { echo 'skip words: node is not here'; echo '0 passed, 0 failed, 1 skipped'; exit 0; }
exec node tests/web/words.mjs
