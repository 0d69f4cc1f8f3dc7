#!/bin/bash
# Checks the layout of the C with clang-format 14, the version whose layout the project keeps.
# Leaves to others: what the code says. Invariant: changes nothing.
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
if $format --dry-run -Werror $(git ls-files '*.c' '*.h' '*.cpp'); then echo '1 passed, 0 failed'; else echo '0 passed, 1 failed'; exit 1; fi
