#!/bin/sh
# Brings what the page is made with: the npm packages of server/web/package-lock.json, into DIRECTORY/node_modules.
# usage: assets_fetch.sh DIRECTORY
# Leaves to others: what is taken of them (assets_embed.py).
# Invariant: asks npm only where the packages of this lock file are not there already; two at once do it once.
set -eu
home=$1
lock=server/web/package-lock.json
mkdir -p "$home"
exec 9>"$home/.fetching"
flock 9
if cmp -s "$lock" "$home/package-lock.json" && [ -d "$home/node_modules/uplot" ]; then exit 0; fi

if ! command -v npm >/dev/null; then
    cat >&2 <<END
The page at / needs the packages of $lock, and npm, which fetches them, is not here.
Install it (docker/install.sh build does on Debian), or put these packages into $home/node_modules and
$lock beside them.
END
    exit 1
fi
new=$home/new
rm -rf "$new"
mkdir "$new"
cp server/web/package.json "$lock" "$new"
if ! npm ci --omit=dev --ignore-scripts --no-audit --no-fund --no-update-notifier --prefix "$new" >"$home/npm.log" 2>&1; then
    cat "$home/npm.log" >&2
    echo "npm could not fetch the packages of $lock, see above; it needs the network once." >&2
    exit 1
fi
rm -rf "$home/node_modules"
mv "$new/node_modules" "$home/node_modules"
cp "$lock" "$home/package-lock.json"
rm -rf "$new"
