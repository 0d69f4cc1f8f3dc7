#!/bin/bash
# Compiles the sources with clang and the flags of the build: its warnings are errors, like gcc's.
# Leaves to others: running the result (make lint). Invariant: writes no files; a source with a warning fails.
set -u
cd "$(dirname "$0")/../.." || exit
command -v clang > /dev/null || { echo 'skip clang: it is not here'; echo '0 passed, 0 failed, 1 skipped'; exit 0; }
passed=0 failed=0
look() { # compiler, flags of, sources of
    local flags sources
    flags=$(make --no-print-directory CC=clang CXX=clang++ B=build/clang WERROR=-Werror "$2") || exit
    mapfile -t sources < <(find core api server tests -name "*.$3" -not -path '*/node_modules/*' -not -path 'tests/bench/*')
    if [ ${#sources[@]} -gt 0 ] && printf '%s\0' "${sources[@]}" | eval xargs -0 -P2 -n16 "$1" -fsyntax-only $flags; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
    fi
}
look clang clang-flags c
look clang++ clang-flags-c++ cpp
echo "$passed passed, $failed failed"
[ $failed = 0 ]
