#!/bin/sh
# Builds the engine for browsers if the tools for WebAssembly are installed, else an empty file: the page then requests every
# motion from the server.
# usage: engine.sh OUT ENGINE_C [yes|no|auto]        builds it; no: an empty file
#        engine.sh --state OUT yes|no|auto           prints whether it was built and what that means; fails if it is required and missing
# Leaves to others: the build (engine.mk), the packages (docker/packages.txt).
# Invariant: two concurrent runs build it once; OUT is complete.
set -eu
# tests whether a C++ module with the engine's headers and libraries can be built
there() {
    try=$(mktemp -d)
    printf '#include <cmath>\n#include <limits>\nextern "C" double one(double x) { return std::sin(x); }\n' >"$try/one.cpp"
    code=0
    "${CLANGXX:-clang++}" --target=wasm32-wasi -msimd128 -mexec-model=reactor -fno-exceptions "$try/one.cpp" -Wl,--export=one -o "$try/one.wasm" \
        >/dev/null 2>&1 || code=1
    rm -rf "$try"
    return $code
}
if [ "$1" = --state ]; then
    if [ -s "$2" ]; then
        echo 'The page has the engine: browsers compute motions themselves.'
    elif [ "$3" = yes ]; then
        echo 'ENGINE=yes, but the tools that compile the engine for browsers are missing. On Debian: docker/install.sh engine. Without it: ENGINE=no' >&2
        exit 1
    else
        printf 'The page has no engine: browsers ask the server for every motion.'
        [ "$3" = no ] && echo || echo ' To add it: docker/install.sh engine, then make again.'
    fi
    exit
fi
mkdir -p "$(dirname "$1")"
exec 9>"$1.lock"
flock 9
if [ "${3:-auto}" != no ] && there; then
    ${MAKE:-make} --no-print-directory -f api/clients/browser/engine.mk OUT="$1" ENGINE_C="$2"
    touch "$1"
else
    : >"$1"
fi
