#!/bin/sh
# Makes the engine for browsers where the tools for WebAssembly are here; else an empty file, with words: the page then asks the
# server for everything.
# usage: engine.sh OUT ENGINE_C        makes it
#        engine.sh --there             true where it can be made
# Leaves to others: how it is made (engine.mk), the packages that it takes (docker/packages.txt).
# Invariant: two at once make it once; OUT is whole.
set -eu
# a module of C and C++ with the headers and the libraries that the engine has
there() {
    try=$(mktemp -d)
    printf '#include <cmath>\n#include <limits>\nextern "C" double one(double x) { return std::sin(x); }\n' >"$try/one.cpp"
    code=0
    "${CLANGXX:-clang++}" --target=wasm32-wasi -msimd128 -mexec-model=reactor -fno-exceptions "$try/one.cpp" -Wl,--export=one -o "$try/one.wasm" \
        >/dev/null 2>&1 || code=1
    rm -rf "$try"
    return $code
}
if [ "$1" = --there ]; then
    there
    exit
fi
mkdir -p "$(dirname "$1")"
exec 9>"$1.lock"
flock 9
if there; then
    ${MAKE:-make} --no-print-directory -f api/clients/browser/engine.mk OUT="$1" ENGINE_C="$2"
    touch "$1"
else
    echo 'The page will ask the server for every motion: clang, lld and the libraries for WebAssembly, by which the engine runs in a browser, are not all here.'
    echo 'Install them: docker/install.sh engine does on Debian.'
    : >"$1"
fi
