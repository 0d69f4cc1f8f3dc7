#!/bin/sh
# Builds the Debian packages of this tree into DIRECTORY: pendulumd, pendulum-client, python3-pendulumd, libpendulum-dev, with what they were
# built from (.buildinfo). lintian has its say where it is installed.
# usage: [DEBFULLNAME=NAME DEBEMAIL=ADDRESS] deb.sh DIRECTORY     who is named is the packages' maintainer; without a name it is nobody
# Leaves to others: the recipe (debian/).
# Invariant: writes into DIRECTORY only; two runs on the same packages make the same bytes, wherever they run.
set -eu
directory=$1
version=$(docker/version.sh)
head=$(head -n 1 debian/changelog)
case $head in
"pendulumd (${version%%+*}) "*) ;;
*)
    echo "deb.sh: debian/changelog begins with '$head', but this is version $version" >&2
    exit 1
    ;;
esac
source=$directory/pendulumd-$version
rm -rf "$directory"
mkdir -p "$source"
cp -R Makefile README.md LICENSE core api server docker debian "$source"
find "$source" -name __pycache__ -prune -exec rm -rf {} +
sed -i "1s/(.*)/($version)/" "$source/debian/changelog"
# who hands the packages on answers for them, and is their maintainer
if [ -n "${DEBEMAIL:-}" ]; then
    maintainer=$(printf '%s <%s>' "${DEBFULLNAME:-pendulumd}" "$DEBEMAIL" | sed 's/[\\&|]/\\&/g')
    sed -i "s|^Maintainer: .*|Maintainer: $maintainer|" "$source/debian/control"
    sed -i "1,/^ -- /s|^ -- .*>  | -- $maintainer  |" "$source/debian/changelog"
fi
export SOURCE_DATE_EPOCH="$(cd "$source" && dpkg-parsechangelog -S Timestamp)"
(cd "$source" && dpkg-buildpackage --build=full --no-sign --jobs="$(nproc)") || exit
rm -rf "$source"
if command -v lintian >/dev/null; then
    lintian --fail-on error,warning --suppress-tags bad-distribution-in-changes-file "$directory"/*.changes
fi
ls "$directory"
