#!/bin/bash
# Builds for 64-bit ARM on another processor, and runs the tests of a room there by an emulator.
# usage: arm64.sh BUILD ROOM [TEST...]     (build/arm64 core); from the top of the tree
# The libraries are Debian's own for arm64, of the release that this machine has, unpacked into BUILD.root: nothing of them is
# installed, and this machine's list of architectures stays as it is.
# Leaves to others: compiler and emulator (packages.txt, arm64), how things are compiled (Makefile).
# Invariant: what is asked of the processor is what every arm64 has: vectors of two doubles (NEON).
set -eu -o pipefail
build=$1 room=$2
shift 2
machine=aarch64-linux-gnu
root=$PWD/$build.root

fetch() {
    local apt=$PWD/$build.apt settings
    mkdir -p "$apt"/{state/lists/partial,cache/archives/partial} "$root.new"
    : > "$apt/status"
    settings=(-qq -o "Dir::State=$apt/state" -o "Dir::State::status=$apt/status" -o "Dir::Cache=$apt/cache"
        -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Acquire::Languages=none -o Debug::NoLocking=1)
    # sources of others may have nothing for arm64
    apt-get "${settings[@]}" update || true
    awk '$1 == "build" && $2 ~ /-dev$/ { print $2 }' docker/packages.txt | sort -u |
        xargs apt-get "${settings[@]}" install -y --download-only --no-install-recommends libc6-dev libstdc++6 >/dev/null
    for package in "$apt"/cache/archives/*.deb; do dpkg-deb -x "$package" "$root.new"; done
    # links to whole paths would lead to this machine's own files
    find "$root.new" -type l -lname '/*' | while read -r link; do
        ln -sfnr "$root.new$(readlink "$link")" "$link"
    done
    rm -rf "$apt"
    mv "$root.new" "$root"
}

[ -d "$root" ] || fetch
libraries=$root/usr/lib/$machine
PKG_CONFIG_SYSROOT_DIR=$root PKG_CONFIG_LIBDIR=$libraries/pkgconfig:$root/usr/share/pkgconfig make --no-print-directory \
    B="$build" CC="$machine-gcc --sysroot=$root" CXX="$machine-g++ --sysroot=$root" AR=$machine-ar \
    LDFLAGS="-Wl,-rpath-link,$libraries -Wl,-rpath-link,$root/lib/$machine" "$build/tests/$room/run"
emulator=$(command -v qemu-aarch64-static || command -v qemu-aarch64)
exec "$emulator" -L "$root" "$build/tests/$room/run" "$@"
