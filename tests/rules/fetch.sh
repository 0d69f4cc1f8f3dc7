#!/bin/bash
# What is there is not fetched: a Debian package is asked for where it is neither installed nor provided by another. Where the
# libraries of the page are not there, the build says how to install them; it takes them from another directory when asked to.
# usage: fetch.sh BUILD     (build/release, after whose build the page's libraries are here)
# Leaves to others: what is taken of them (server/http/assets_bundle.sh).
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

bundle() { server/http/assets_bundle.sh $work/page 2>$work/said; }
refuse() { ! bundle; }
same() { diff -r build/web/bundles $work/page; }
export SHARE=$work/share
check 'without the libraries of the page it fails' refuse
check 'and says what to do' grep -q 'docker/install.sh build' $work/said
mkdir -p $SHARE
for folder in javascript doc; do ln -s /usr/share/$folder $SHARE; done
check 'another directory that has them serves' bundle
check 'with the same files' same

# Debian's packages, where there is no apt: who would install says so. A library that a newer Debian renamed provides its old name,
# as whichever awk is installed provides awk.
if command -v dpkg-query >/dev/null; then
    for tool in sh cut cat dirname grep dpkg-query tr; do ln -sf "$(command -v $tool)" $work/bin/$tool; done
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
