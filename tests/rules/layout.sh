#!/bin/bash
# Checks the layout of the C sources with clang-format 14, the version that the project uses.
# usage: layout.sh [--write]     --write formats the sources
# Leaves to others: the contents of the code. Invariant: changes nothing without --write.
cd "$(dirname "$0")/../.." || exit
for format in clang-format-14 clang-format; do
    version=$($format --version 2>/dev/null) && [[ $version = *' 14.'* ]] && break
    format=
done
if [ -z "$format" ]; then
    echo 'skip layout: clang-format 14 is not here'
    echo '0 passed, 0 failed, 1 skipped'
    exit 0
fi
# a tarball has no list of its files: all that are there, then
mapfile -t sources < <(find api core server tests \( -name '*.c' -o -name '*.h' -o -name '*.cpp' \) -not -path '*/node_modules/*')
if [ ${#sources[@]} -lt 100 ]; then
    echo "FAIL only ${#sources[@]} sources were found"
    echo '0 passed, 1 failed'
    exit 1
fi
if [ "${1:-}" = --write ]; then exec $format -i "${sources[@]}"; fi
if $format --dry-run -Werror "${sources[@]}"; then echo '1 passed, 0 failed'; else echo '0 passed, 1 failed'; exit 1; fi
