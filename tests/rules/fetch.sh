#!/bin/bash
# Tests that nothing is fetched that is there already: a Debian package is installed only if neither it nor a package that provides
# it is there. Without the page's libraries, the build explains how to install them; it can take them from another directory.
# usage: fetch.sh BUILD     (build/release, after whose build the page's libraries are here)
# Leaves to others: the files taken from the libraries (server/http/assets_bundle.sh).
# Invariant: no network access; writes into build/check only.
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
