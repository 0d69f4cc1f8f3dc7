#!/bin/sh
# Makes what a release consists of, in DIRECTORY: the sources of a commit as an archive, the Debian packages of build/deb where these
# were built, SHA256SUMS with the digest of each, and the signature of that; and verifies what somebody else has made.
# usage: dist.sh DIRECTORY KEY [COMMIT]         KEY: a private key of ssh-keygen, or - for none; COMMIT: HEAD
#        dist.sh --verify DIRECTORY SIGNERS     SIGNERS: lines "NAME namespaces="pendulumd-release" ssh-ed25519 AAAA..."
# Leaves to others: the packages (deb.sh), whose key is to be believed (releases.md).
# Invariant: one commit makes one archive, to the byte, wherever and whenever; verified is only what is listed, whole, and signed.
set -eu
umask 022
export LC_ALL=C
if [ "$1" = --verify ]; then
    directory=$2 signers=$(realpath "$3")
    cd "$directory"
    name=$(ssh-keygen -Y find-principals -s SHA256SUMS.sig -f "$signers" | head -n 1) || name=
    [ -n "$name" ] || { echo "dist.sh: the signature is of nobody whom $signers names" >&2; exit 1; }
    ssh-keygen -Y verify -f "$signers" -I "$name" -n pendulumd-release -s SHA256SUMS.sig < SHA256SUMS
    sha256sum --check --strict SHA256SUMS
    # a name that begins with a dot is one too; a pattern that finds none stays as it is
    for file in * .[!.]* ..?*; do
        [ -e "$file" ] || [ -L "$file" ] || continue
        case $file in
        SHA256SUMS | SHA256SUMS.sig) ;;
        *) awk -v file="$file" '$2 == file { found = 1 } END { exit !found }' SHA256SUMS || { echo "dist.sh: $file is not listed, and so not signed" >&2; exit 1; } ;;
        esac
    done
    exit
fi
directory=$1 key=$2 commit=${3:-HEAD}
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
git archive "$commit" docker/version.sh core/base/status.h 2>/dev/null | tar -x -C "$tree" && version=$("$tree/docker/version.sh") || version=
[ -n "$version" ] || { echo "dist.sh: $commit has no version" >&2; exit 1; }
# what is there already may be a release that somebody has fetched, or all that they have
[ ! -e "$directory" ] || rmdir "$directory" 2> /dev/null || { echo "dist.sh: $directory is there already" >&2; exit 1; }
mkdir -p "$directory"
# the archive's times are those of the commit, and its modes are nobody's setting; gzip is told to note no time
git -c tar.umask=0022 archive --format=tar --prefix="pendulumd-$version/" "$commit" | gzip -9n > "$directory/pendulumd-$version.tar.gz"
for package in build/deb/*_"$version"_*.deb; do
    if [ -e "$package" ]; then cp "$package" "$directory"; fi
done
sums=$(cd "$directory" && sha256sum -- *)
printf '%s\n' "$sums" > "$directory/SHA256SUMS"
if [ "$key" = - ]; then
    echo "dist.sh: without a key nothing is signed" >&2
else
    ssh-keygen -q -Y sign -f "$key" -n pendulumd-release "$directory/SHA256SUMS"
fi
ls "$directory"
