#!/bin/sh
# Whether this tree can be released, and the tag of the release. `make release` calls it.
# usage: release.sh --ready          says what is missing; exit status 1 if anything is
#        release.sh --tag KEY        tags HEAD as vX.Y.Z, signed by KEY (a private key of ssh-keygen), or - for a plain tag
# Leaves to others: the checks (make check), packages (deb.sh), archive and digests (dist.sh). Invariant: an existing tag is never moved.
set -eu
cd "$(dirname "$0")/.."
version=$(sed -nE 's/^#define PEND_VERSION "(.*)"$/\1/p' core/base/status.h)
missing() {
    echo "release.sh: $1" >&2
    ready=no
}
ready=yes
[ -z "$(git status --porcelain)" ] || missing "the tree has changes that are not committed"
! git rev-parse -q --verify "refs/tags/v$version" >/dev/null || missing "v$version is tagged already: raise PEND_VERSION in core/base/status.h"
grep -qE "^## \[$version\] - [0-9]{4}-[0-9]{2}-[0-9]{2}$" CHANGELOG.md || missing "CHANGELOG.md has no line '## [$version] - YYYY-MM-DD'"
head -n 1 debian/changelog | grep -qF "($version) " || missing "debian/changelog begins with another version than $version"
dated=$(sed -nE "s/^## \\[$version\\] - (.*)/\\1/p" CHANGELOG.md)
[ "$(date -u -d "$(sed -n '/^ -- /{s/^ -- .*>  //p;q}' debian/changelog)" +%F)" = "$dated" ] || missing "debian/changelog has another date than CHANGELOG.md ($dated)"
grep -qF "version = {$version}" cite.bib || missing "cite.bib has another version than $version"
grep -qx "version: $version" CITATION.cff || missing "CITATION.cff has another version than $version"
[ $ready = yes ]
[ "$1" = --ready ] && exit
if [ "$2" = - ]; then
    git tag -a -m "pendulumd $version" "v$version"
else
    git -c gpg.format=ssh -c user.signingkey="$2" tag -s -m "pendulumd $version" "v$version"
fi
