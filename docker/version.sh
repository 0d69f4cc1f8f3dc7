#!/bin/sh
# Prints the version of this tree: 0.1.0 for the commit of the tag v0.1.0, 0.1.0+git20261126.abc1234 for any other commit,
# 0.1.0+unreleased where no commit is known, or PENDULUMD_VERSION where that is set (by a package, an image).
# usage: version.sh [C-FILE]     with a file: writes it, if it would change, with `api_version` of that version
# Leaves to others: the number itself (core/base/status.h). Invariant: an archive of a commit (dist.sh) has the version of the commit.
set -eu
cd "$(dirname "$0")/.."
version=$(sed -nE 's/^#define PEND_VERSION "(.*)"$/\1/p' core/base/status.h)
# git archive writes the commit's date, its name and its tag here; nothing that differs between clones
archived='$Format:%cs %H %(describe:tags=true,abbrev=40,match=v*)$'
case $archived in
\$*) archived=$([ -e .git ] && git log -1 --format='%cs %H %(describe:tags=true,abbrev=40,match=v*)' 2>/dev/null) || archived= ;;
esac
case $archived in
*" v$version") ;;
'') version=$version+unreleased ;;
*) version=$version+git$(echo "$archived" | sed -E 's/^(....)-(..)-(..) ([0-9a-f]{8}).*/\1\2\3.\4/') ;;
esac
version=${PENDULUMD_VERSION:-$version}
if [ $# = 0 ]; then
    echo "$version"
else
    text="#include \"api/base/engine.h\"
const char api_version[] = \"$version\";"
    [ -e "$1" ] && [ "$(cat "$1")" = "$text" ] || printf '%s\n' "$text" > "$1"
fi
