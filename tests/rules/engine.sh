#!/bin/bash
# Compares the engine for browsers with native code of the base instruction set: the paper's example and a thousand random requests.
# usage: engine.sh BUILD     (build/release, for the native door, tests/engine/native)
# Also tests that without the tools for WebAssembly the page is built without the engine, with a message.
# Leaves to others: the requests and the comparison (tests/engine), the page that uses the engine (tests/web).
# Invariant: without node or the tools for WebAssembly it is reported as skipped.
set -u
cd "$(dirname "$0")/../.." || exit
skip() { echo "skip engine: $1"; finish 0 0 1; }
passed=0 failed=0
say() { if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; fi; }
work=$(mktemp -d "$PWD/build/engine.XXXXXX") || exit
trap 'rm -rf "$work"' EXIT
CLANGXX=false api/clients/browser/engine.sh "$work/engine.wasm" "$1/api/base/engine.c" && api/clients/browser/engine.sh --state "$work/engine.wasm" auto >"$work/said"
insists() { ! api/clients/browser/engine.sh --state "$work/engine.wasm" yes 2>"$work/refused" && grep -q 'docker/install.sh engine' "$work/refused"; }
say 'ENGINE=yes fails without the engine, and names the command that helps' insists
page() { /usr/bin/python3 -B server/http/assets_embed.py server/web build/web/bundles "$1" api/guide; }
without() { [ -e "$work/engine.wasm" ] && [ ! -s "$work/engine.wasm" ] && page "$work/engine.wasm" >"$work/page.c" && ! grep -q 'engine\.wasm"' "$work/page.c" && ! grep -q 'html lang.*data-engine' "$work/page.c"; }
with() { page build/web/engine.wasm >"$work/page.c" && grep -q '"engine\.wasm", "application/wasm"' "$work/page.c" && grep -q 'html lang.*data-engine' "$work/page.c"; }
say 'without the tools the build says what the page does' grep -q 'ask the server' "$work/said"
say 'without the tools the page names no engine' without
[ ! -s build/web/engine.wasm ] || say 'with them it does' with
finish() { echo "$((passed + ${1:-0})) passed, $((failed + ${2:-0})) failed, ${3:-0} skipped"; [ $((failed + ${2:-0})) = 0 ]; exit; }
command -v node >/dev/null || skip 'node is not here'
[ -s build/web/engine.wasm ] || skip 'the tools for WebAssembly are not here (docker/install.sh engine installs them)'
node tests/engine/bits.mjs build/web/engine.wasm "$1/tests/engine/native" 1000 | tee "$work/bits" | grep -v ' passed, '
read -r good _ bad _ < <(tail -n 1 "$work/bits")
finish "${good:-0}" "${bad:-1}"
