#!/bin/bash
# Tests that sources give the same bytes in any directory, under any clock, language and file permissions.
# usage: same.sh BUILD
# A few objects of each kind stand for all: C, C++, a kernel (for the base instruction set), generated files, the page, and an
# engine for browsers of a few objects. The page has the whole engine of this directory.
# Leaves to others: fetching the page's tools (fetch.sh). Invariant: writes only into its own directory in build/.
set -u
cd "$(dirname "$0")/../.." || exit
root=$(mktemp -d "$PWD/build/same.XXXXXX") || exit
trap 'rm -rf "$root"' EXIT
passed=0 failed=0
objects=({core/tree/tree,core/simd/kernel_sincos.base,api/number/number_write,api/base/engine,api/call/openapi_json,server/main}.o libpendulum.a)
# what the archive has of the core; all of it would take a minute
few='CORE=$(B)/core/tree/tree.o $(B)/core/simd/kernel_sincos.base.o'
engine=('OBJECTS=$(D)/core/tree/tree.o $(D)/core/simd/kernel_sincos.o $(D)/api/number/number_write.o $(D)/engine.o'
    'LINK=--target=wasm32-wasi -mexec-model=reactor -O2 -lm -Wl,--no-gc-sections,--strip-all,--import-undefined')

# directory, settings of its environment
built() {
    mkdir -p "$1/build" && cp -r Makefile core api server docker "$1" && cp -r build/web "$1/build" || return
    rm -rf "$1"/build/web/{assets.*,bundled,bundles} "$1"/server/web/node_modules
    env "${@:2}" CCACHE_DISABLE=1 make --no-print-directory -C "$1" -o build/web/engine.wasm "$few" "${objects[@]/#/build/release/}" build/web/assets.o &&
        if [ -s "$1/build/web/engine.wasm" ]; then
            env "${@:2}" make --no-print-directory -C "$1" -f api/clients/browser/engine.mk "${engine[@]}" OUT=build/few.wasm ENGINE_C=build/release/api/base/engine.c
        else
            : > "$1/build/few.wasm"
        fi
}
log=$root.log
{ built "$root/one" TZ=UTC LC_ALL=C && sleep 1.1 &&
    (umask 077; built "$root/another one, elsewhere" TZ=Pacific/Auckland LC_ALL=C.UTF-8); } > "$log" 2>&1 ||
    { failed=1; tail -n 20 "$log"; echo 'FAIL the two builds'; }
rm -f "$log"

for object in "${objects[@]/#/build/release/}" build/few.wasm build/web/assets.o; do
    if cmp "$root/one/$object" "$root/another one, elsewhere/$object"; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAIL $object is another in another directory"
    fi
done
# who reads the bytes finds the directory in none of them
if grep -rl --include='*.o' -- "$root" "$root"; then failed=$((failed + 1)); echo 'FAIL the name of the directory'; else passed=$((passed + 1)); fi
echo "$passed passed, $failed failed"
[ $failed = 0 ]
