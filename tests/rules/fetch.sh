#!/bin/bash
# What is there is not fetched: of what the page is made with, a directory that has it and the user's cache serve where npm
# is not; a Debian package is asked for where it is neither installed nor provided by another.
# usage: fetch.sh BUILD     (build/release, after whose build the page's packages are here)
# Leaves to others: what is taken of them (server/http/assets_embed.py).
# Invariant: asks no network; writes into build/check alone.
set -u
cd "$(dirname "$0")/../.." || exit
work=build/check/fetched
rm -rf $work
mkdir -p $work/bin
passed=0 failed=0
check() { # what, then a command
    if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; fi
}

# a machine without npm; or with one that brings what is here, and notes that it was asked
for tool in sh cut sha256sum cmp mkdir flock rm cat cp mv find sort xargs touch; do ln -s "$(command -v $tool)" $work/bin/$tool; done
export XDG_CACHE_HOME=$PWD/$work/cache
fetch() { PATH=$PWD/$work/bin server/http/assets_fetch.sh "$@" 2>$work/said; }
refuse() { ! fetch "$@"; }
same() { for one in uplot katex qrcode-generator; do diff -r build/web/node_modules/$one "$1/node_modules/$one" >/dev/null || return; done; }
asked() { [ "$(wc -l <$work/asked)" = "$1" ]; }

check 'without npm and packages it fails' refuse $work/a
check 'and says what to do' grep -q 'WEB_PACKAGES' $work/said
check 'it knows that npm is needed' refuse --there $work/a

export WEB_PACKAGES=$PWD/build/web/node_modules
check 'a directory that has them serves' fetch $work/b
check 'with the same files' same $work/b
unset WEB_PACKAGES

cat >$work/bin/npm <<END
#!/bin/sh
echo asked >>$PWD/$work/asked
for last; do :; done
cp -R $PWD/build/web/node_modules "\$last/node_modules"
END
chmod +x $work/bin/npm
: >$work/asked
check 'npm brings them' fetch $work/c
check 'npm was asked' asked 1
check 'the cache is enough from then on' fetch --there $work/d
rm -r $work/c
check 'it serves after a make clean' fetch $work/c
check 'npm was not asked again' asked 1
check 'with the same files as npm brought' same $work/c

find "$XDG_CACHE_HOME" -name uPlot.iife.min.js -exec sh -c 'echo damaged >>"$1"' sh {} \;
check 'a damaged cache is none' refuse --there $work/e
check 'npm is asked for what was damaged' fetch $work/e
check 'once more' asked 2
check 'and brings the right files' same $work/e

# Debian's packages, where there is no apt: who would install says so. A library that a newer Debian renamed provides its old name,
# as whichever awk is installed provides awk.
if command -v dpkg-query >/dev/null; then
    rm $work/bin/npm
    for tool in dirname grep dpkg-query tr; do ln -sf "$(command -v $tool)" $work/bin/$tool; done
    cp docker/install.sh $work
    wanted() { printf 'build %s - a reason\n' "$@" >$work/packages.txt; PATH=$PWD/$work/bin sh $work/install.sh build >$work/said 2>&1; }
    quiet() { wanted "$@" && [ ! -s $work/said ]; }
    told() { wanted "$@" && grep -q "no apt-get.*: $1 \$" $work/said; }
    check 'a package that is installed is not asked for' quiet dpkg
    check 'nor one that another provides' quiet awk
    check 'one that is not there is' told no-package-has-this-name
    check 'though its name is a part of another' told dpk
fi

echo "$passed passed, $failed failed"
[ $failed = 0 ]
