#!/bin/bash
# Lints api/call/openapi.yaml with spectral, unchanged and as OpenAPI 3.0, and with redocly; two generators make types of it, with which valid programs compile and
# invalid ones (shapes.ts) do not, and two make clients that compile; if npm can fetch them (package.json).
# Leaves to others: whether the document is true (docs.sh, replies.py).
# Invariant: fetched and generated files are in build/; errors and warnings fail.
set -u
cd "$(dirname "$0")/../.." || exit
home=build/spectral
skip() { echo "skip openapi: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }

# shellcheck source=tests/rules/npm.sh
. tests/rules/npm.sh
command -v npm >/dev/null || skip 'npm is not here (make lint installs it)'
fetch_packages tests/rules $home || skip 'npm cannot fetch spectral and the generators'
tool() { "$home/node_modules/.bin/$1" "${@:2}"; }
passed=0 failed=0
check() { # what, then a command
    if "${@:2}" >$home/said 2>&1; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; cat $home/said; fi
}
compiles() { # directory: the programs, with the types that were generated there
    cp tests/rules/shapes.ts "$1/shapes.ts"
    tool tsc --strict --skipLibCheck --noEmit --noUncheckedIndexedAccess --exactOptionalPropertyTypes --target ES2022 --module NodeNext "$1/shapes.ts"
}
types=$home/types
mkdir -p $types/openapi-typescript $types/swagger-typescript-api $types/orval $types/hey-api
for form in json twin; do
    /usr/bin/python3 api/call/openapi_embed.py --$form api/call/openapi.yaml >$home/$form.json
done
check 'spectral finds nothing' tool spectral lint --fail-severity=warn --ruleset tests/rules/.spectral.yaml $home/json.json
check 'spectral finds nothing in it as OpenAPI 3.0' tool spectral lint --fail-severity=warn --ruleset tests/rules/.spectral.yaml $home/twin.json
check 'openapi-typescript makes types' tool openapi-typescript $home/json.json --default-non-nullable=false --root-types \
    --root-types-no-schema-prefix --output $types/openapi-typescript/generated.ts
check 'of its types right programs compile, and wrong ones do not' compiles $types/openapi-typescript
# their own formatters and parsers fail on the Node.js of Debian 12
skipped=0
unwarned() { "$@" && ! "$@" 2>&1 | grep -q 'You have .* warning'; }
client() { # the directory, then the generator
    "${@:2}" && tool tsc --strict --noEmit --target ES2022 --module ESNext --moduleResolution Bundler --lib ES2022,DOM,DOM.Iterable $(find "$1" -name '*.ts')
}
if [ "$(node -p 'parseInt(process.versions.node)')" -ge 20 ]; then
    check 'swagger-typescript-api makes types' tool swagger-typescript-api generate --path $home/json.json --output $types/swagger-typescript-api \
        --name generated.ts --no-client --generate-union-enums
    check 'of its types right programs compile, and wrong ones do not' compiles $types/swagger-typescript-api
    check 'redocly finds nothing' unwarned tool redocly lint $home/json.json
    check 'the client of orval compiles' client $types/orval tool orval --client fetch --input $home/json.json --output $types/orval/client.ts
    check 'the client of hey-api compiles' client $types/hey-api tool openapi-ts -i $home/json.json -o $types/hey-api
else
    echo 'skip swagger-typescript-api, redocly, orval and hey-api: they are for Node.js 20 and later'
    skipped=5
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed = 0 ]
