#!/bin/sh
# Makes few files of the page's many, so that a browser asks a few times: scripts and styles of server/web into DIRECTORY. Each
# drawer is one file of its own, which is asked for when it is opened first. Adds the libraries of Debian's packages, under lib/.
# usage: [SHARE=DIRECTORY] assets_bundle.sh DIRECTORY     (SHARE, instead of /usr/share: has the folders javascript and doc)
# Leaves to others: documents, what is compiled in (assets_embed.py).
# Invariant: the sources work as they lie there too (tests/web/serve.mjs); nothing is made of them that they do not say.
set -eu
home=$1
if ! command -v esbuild >/dev/null; then
    cat >&2 <<END
The page at / is bundled by esbuild, which is not here. Install it: docker/install.sh build does on Debian.
END
    exit 1
fi
share=${SHARE:-/usr/share}
katex=$share/javascript/katex qrcode=$share/javascript/qrcode-generator/qrcode.js
for file in "$katex/katex.mjs" "$katex/katex.min.css" "$katex/fonts/KaTeX_Main-Regular.woff2" "$qrcode"; do
    [ -e "$file" ] || {
        echo "The page at / needs $file, of Debian's libjs-katex, fonts-katex and node-qrcode-generator. Install them: docker/install.sh build" >&2
        exit 1
    }
done
new=$home.$$
rm -rf "$new"
trap 'rm -rf "$new"' EXIT
cd server/web
# what is loaded when it is wanted, a drawer, a part of a class or words, exports that by default; the others are what it is made of
drawers=$(grep -l "^export default [afm{]" drawers/*.js drawers/*/*.js class/*.js text/*/*.js | grep -v "^text/en/page")
# shellcheck disable=SC2086  # names without blanks
esbuild early.js main.js sw.js engine_worker.js embed.js docs.js page.css docs.css class/class.css drawers/*/*.css $drawers --bundle --outbase=. --format=esm --minify --charset=utf8 --legal-comments=none \
    --log-level=warning --outdir="$OLDPWD/$new"
cd "$OLDPWD"
mkdir -p "$new/lib/fonts"
esbuild "$katex/katex.mjs" --minify --format=esm --charset=utf8 --legal-comments=none --log-level=warning --outfile="$new/lib/katex.js"
esbuild "$qrcode" --bundle --minify --format=esm --charset=utf8 --legal-comments=none --log-level=warning --outfile="$new/lib/qrcode.js"
cp "$katex"/fonts/*.woff2 "$new/lib/fonts"
# one form of each font: every browser that reads ES modules reads it
sed "s/src:\\(url([^)]*\\.woff2) format(['\"]woff2['\"])\\)[^;}]*/src:\\1/g" "$katex/katex.min.css" >"$new/lib/katex.css"
if grep -q '\.ttf' "$new/lib/katex.css"; then
    echo "assets_bundle: KaTeX's style is not what it was" >&2
    exit 1
fi
for package in libjs-katex node-qrcode-generator; do
    printf '%s\n\n' $package
    cat "$share/doc/$package/copyright"
done >"$new/lib/licenses.txt"
# each file is moved whole: builds that run side by side may make it at once
(cd "$new" && find . -type d) | while read -r folder; do mkdir -p "$home/$folder"; done
(cd "$home" && find . -type f) | while read -r file; do [ -e "$new/$file" ] || rm -f "$home/$file"; done
(cd "$new" && find . -type f) | while read -r file; do mv -f "$new/$file" "$home/$file"; done
