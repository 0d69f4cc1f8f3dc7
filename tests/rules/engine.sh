#!/bin/bash
# Compares the engine for browsers with native code of the base instruction set: the paper's example and a thousand random requests.
# usage: engine.sh BUILD     (build/release, for the native door, tests/engine/native)
# Leaves to others: the requests and the comparison (tests/engine), the page that asks the engine (tests/web).
# Invariant: without node or the tools for WebAssembly it says so and skips itself.
set -u
cd "$(dirname "$0")/../.." || exit
skip() { echo "skip engine: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }
command -v node >/dev/null || skip 'node is not here'
[ -s build/web/engine.wasm ] || skip 'the tools for WebAssembly are not here (docker/install.sh engine installs them)'
exec node tests/engine/bits.mjs build/web/engine.wasm "$1/tests/engine/native" 1000
