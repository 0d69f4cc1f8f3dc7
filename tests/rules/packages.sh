#!/bin/bash
# Tests the Debian packages' manual page, bill of materials (SBOM) and version; and that an altered release
# fails the check of its signature.
# usage: packages.sh BUILD             in a second
#        packages.sh --whole ROOT...   builds the packages twice, in two places, and compares their bytes; installs, tests,
#                                      removes and purges them in each ROOT, a bare Debian; minutes, as root
# Leaves to others: building them (docker/deb.sh). Invariant: writes into build/ and the ROOTs only.
set -u
cd "$(dirname "$0")/../.." || exit
passed=0 failed=0
say() { if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $1"; fi; }
root=$(mktemp -d "$PWD/build/packages.XXXXXX") || exit
trap 'rm -rf "$root"' EXIT
end() {
    echo "$passed passed, $failed failed"
    [ $failed = 0 ]
    exit
}

if [ "$1" = --whole ]; then
    shift
    there="$root/another place"
    build() { make --no-print-directory deb > "$root/log" 2>&1 || { tail -n 20 "$root/log"; return 1; }; }
    say 'the packages' build
    mkdir -p "$there/build"
    cp -R Makefile README.md LICENSE core api server docker debian "$there" && cp -R build/web "$there/build"
    say 'the packages elsewhere' env -C "$there" -u MAKEFLAGS TZ=Pacific/Auckland bash -c "umask 077; $(declare -f build); root='$root'; build"
    for package in build/deb/*.deb; do
        say "$(basename "$package") has other bytes in another place" cmp "$package" "$there/$package"
    done
    rm -rf "$there"
    for bare; do
        try() {
            cp build/deb/*.deb "$bare/root" && unshare --mount --pid --fork chroot "$bare" /bin/sh -eu -c '
                mount -t proc proc /proc
                export DEBIAN_FRONTEND=noninteractive
                cd /root
                apt-get -qq update
                apt-get -qq install -y --no-install-recommends ./pendulumd_*.deb ./pendulum-client_*.deb curl
                pendulumd --version
                PENDULUMD_ALLOW_ROOT=on pendulumd --listen 127.0.0.1:18082 --store none &
                for i in 1 2 3 4 5 6 7 8 9; do curl -fsS http://127.0.0.1:18082/readyz && break; sleep 1; done
                echo "{\"length\":[1],\"mass\":[1],\"parent\":[0]}" > one.json
                pendulum --server http://127.0.0.1:18082 run one.json --t 0,1 > far
                pendulum run one.json --t 0,1 --local > near
                cmp far near
                kill %1 && wait %1
                touch /etc/default/pendulumd; mkdir -p /var/lib/private/pendulumd
                apt-get -qq remove -y pendulumd pendulum-client
                test ! -e /usr/bin/pendulumd && test -e /etc/default/pendulumd && test -e /var/lib/private/pendulumd
                apt-get -qq purge -y pendulumd
                test ! -e /etc/default/pendulumd && test ! -e /var/lib/private/pendulumd
                rm -f /root/*.deb one.json far near' > "$root/log" 2>&1 || { tail -n 20 "$root/log"; return 1; }
        }
        say "$bare" try
    done
    end
fi

build=$1
version=$("$build/pendulumd" --version | cut -d' ' -f2)
listed() { head -n 1 debian/changelog | grep -qF "pendulumd (${version%%+*}) "; }
say "debian/changelog begins with another version than $version" listed
needed() { diff <(sed -nE 's/^(build|client|engine) +([a-z0-9.+-]+) .*/ \2,/p' docker/packages.txt | grep -vxE ' (gcc|g\+\+|make),') <(sed -n '/^Build-Depends/,/^$/p' debian/control | grep '^ [a-z]' | grep -v debhelper); }
say 'debian/control needs other packages than docker/packages.txt has for build, client and engine' needed

page=$root/pendulumd.8
say 'the manual page' eval 'docker/manual.py "$build/pendulumd" > "$page"'
for option in $("$build/pendulumd" --help | sed -nE 's/^  --([a-z-]+) .*/\1/p'); do
    say "the manual page says nothing of --$option" grep -qE '^\.BI? \\-\\-'"${option//-/\\\\-}( |\$)" "$page"
done
plain() { ! command -v man > /dev/null || [ -z "$(LC_ALL=C.UTF-8 man --warnings -l "$page" 2>&1 > /dev/null)" ]; }
say 'the manual page has warnings' plain

made() { SOURCE_DATE_EPOCH=1 docker/sbom.py "$build" "$root/$1"; }
say 'what it is made of' made one
say 'the same again' made two
say 'the second differs' diff -r "$root/one" "$root/two"
held() {
    python3 -B - "$build" "$root/one" <<'END'
import json, re, subprocess, sys
build, directory = sys.argv[1:]
cdx, spdx = (json.load(open(f"{directory}/sbom.{kind}.json", encoding="utf-8")) for kind in ("cdx", "spdx"))
names = {part["name"] for part in cdx["components"]}
assert names == {part["name"] for part in spdx["packages"]} - {"pendulumd"}
assert {"libjs-katex", "fonts-katex", "node-qrcode-generator", "libdragonbox-dev", "libmicrohttpd12", "libc6"} <= {re.sub("t64$", "", name) for name in names}, names
# every file that the loader maps for what a program asks for is of a package that is listed
wanted = set(re.findall(r"NEEDED.*\[(.*)\]", subprocess.run(["readelf", "-d", f"{build}/pendulumd", f"{build}/pendulum"], stdout=subprocess.PIPE,
                                                            text=True).stdout))
assert len(wanted) > 12, wanted
owners = subprocess.run(["dpkg", "-S"] + [f"*/{library}" for library in wanted], stdout=subprocess.PIPE, text=True).stdout.splitlines()
for library in wanted:
    assert any(line.endswith("/" + library) and line.split(":")[0] in names for line in owners), library
for part in spdx["packages"][1:]:
    assert part["versionInfo"] and part["externalRefs"][0]["referenceLocator"].startswith("pkg:deb/debian/"), part
keys = [part["SPDXID"] for part in spdx["packages"]]
assert len(keys) == len(set(keys))
END
}
say 'it lacks something' held

# a release is made twice, of one commit, and verified; then spoilt in every way that must be seen
releases() {
    local made=$root/made again=$root/again
    docker/dist.sh "$made" "$root/key" > "$root/log" 2>&1 || { cat "$root/log"; return 1; }
    say 'a release is other bytes the second time' bash -c 'umask 077; export GIT_CONFIG_COUNT=1 GIT_CONFIG_KEY_0=tar.umask GIT_CONFIG_VALUE_0=user; TZ=Pacific/Auckland docker/dist.sh "$2" "$3" > "$4" 2>&1 && cmp "$1"/*.tar.gz "$2"/*.tar.gz' - "$made" "$again" "$root/key" "$root/log"
    say 'the sources hold a program' bash -c '! tar -xzOf "$1"/*.tar.gz | grep -q "^.ELF"' - "$made"
    docker/dist.sh --verify "$made" "$root/signers" > "$root/log" 2>&1
}
spoilt() { # what is said of it, how
    rm -rf "$root/spoilt" && cp -R "$root/made" "$root/spoilt" && (cd "$root/spoilt" && eval "$2")
    ! docker/dist.sh --verify "$root/spoilt" "${3:-$root/signers}" > "$root/log" 2>&1 && grep -q "$1" "$root/log"
}
if command -v ssh-keygen > /dev/null && git rev-parse HEAD > /dev/null 2>&1; then
    for key in key other; do
        ssh-keygen -q -t ed25519 -N '' -C '' -f "$root/$key"
        echo "maker namespaces=\"pendulumd-release\" $(cat "$root/$key.pub")" > "$root/signers.$key"
    done
    mv "$root/signers.key" "$root/signers"
    say 'a release' releases
    say 'a directory that holds something is lost' bash -c '! docker/dist.sh "$1" - 2> /dev/null && docker/dist.sh --verify "$1" "$2" > /dev/null 2>&1' - "$root/made" "$root/signers"
    say 'a byte of the archive' spoilt 'FAILED' 'printf x >> *.tar.gz'
    say 'a digest that was made to fit' spoilt 'incorrect signature\|Could not verify' 'printf x >> *.tar.gz; sha256sum *.tar.gz > SHA256SUMS'
    say 'a file that is not listed' spoilt 'is not listed' 'touch evil.deb'
    say 'a hidden file that is not listed' spoilt 'is not listed' 'touch .evil.deb'
    say 'a file that is missing' spoilt 'No such file' 'rm *.tar.gz'
    say 'no signature' spoilt 'is of nobody' 'rm SHA256SUMS.sig'
    say 'the key of somebody else' spoilt 'is of nobody' true "$root/signers.other"
else
    echo 'skip packages: releases are made of a clone, and signed by ssh-keygen'
fi
end
