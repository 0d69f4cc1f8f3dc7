#!/bin/sh
# Brings what the page is made with: the npm packages of server/web/package-lock.json, into DIRECTORY/node_modules.
# usage: assets_fetch.sh DIRECTORY           brings them
#        assets_fetch.sh --there DIRECTORY   true where that takes no npm
# They come from the first place that has them: DIRECTORY itself; WEB_PACKAGES, a directory with a folder for each package, for
# those who build without a network; pendulumd's folder of the user's cache ($XDG_CACHE_HOME, ~/.cache), which `make clean` leaves
# alone; npm, whose answer goes into that folder.
# Leaves to others: what is taken of them (assets_embed.py).
# Invariant: npm is asked at most once for a lock file, and checks what it brings against the lock file's digests; what lies in the
# cache is checked against what npm brought; two at once do it once.
set -eu
ask=
[ "$1" != --there ] || { ask=1; shift; }
home=$1
lock=server/web/package-lock.json
packages='uplot katex qrcode-generator'
sums=files.sha256

digest=$(sha256sum <"$lock" | cut -c1-16)
cache=${XDG_CACHE_HOME:-${HOME:-/nonexistent}/.cache}/pendulumd/page-$digest

have() { # directory
    for package in $packages; do [ -d "$1/$package" ] || return 1; done
}
here() { cmp -s "$lock" "$home/package-lock.json" && have "$home/node_modules"; }
given() { [ -n "${WEB_PACKAGES:-}" ] && have "$WEB_PACKAGES"; }
cached() { [ -f "$cache/$sums" ] && (cd "$cache" && sha256sum --status -c "$sums") && have "$cache/node_modules"; }

if [ -n "$ask" ]; then
    here || given || cached
    exit
fi
mkdir -p "$home"
exec 9>"$home/.fetching"
flock 9
if here; then exit 0; fi

new=$home/new
rm -rf "$new"
mkdir "$new"
trap 'rm -rf "$new"' EXIT
fetched=
if given; then
    mkdir "$new/node_modules"
    for package in $packages; do cp -RL "$WEB_PACKAGES/$package" "$new/node_modules/$package"; done
elif cached; then
    cp -R "$cache/node_modules" "$new/node_modules"
elif ! command -v npm >/dev/null; then
    cat >&2 <<END
The page at / needs the packages of $lock, and npm, which fetches them, is not here.
Install it (docker/install.sh page does on Debian), or name a directory that has them: WEB_PACKAGES=DIRECTORY make build
END
    exit 1
else
    cp server/web/package.json "$lock" "$new"
    if ! npm ci --omit=dev --ignore-scripts --prefer-offline --no-audit --no-fund --no-update-notifier --prefix "$new" >"$home/npm.log" 2>&1; then
        cat "$home/npm.log" >&2
        echo "npm could not fetch the packages of $lock, see above; it needs the network once." >&2
        exit 1
    fi
    fetched=1
fi

# a cache that cannot be written is none
keep() {
    part=$cache.$$
    mkdir -p "$part" && cp -R "$new/node_modules" "$part/node_modules" || return
    (cd "$part" && find node_modules -type f | LC_ALL=C sort | xargs -d '\n' sha256sum >"$sums") || return
    rm -rf "$cache" && mv "$part" "$cache"
}
if [ -n "$fetched" ]; then keep 2>/dev/null || rm -rf "$cache.$$"; fi

rm -rf "$home/node_modules"
mv "$new/node_modules" "$home/node_modules"
cp "$lock" "$home/package-lock.json"
