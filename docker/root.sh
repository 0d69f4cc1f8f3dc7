#!/bin/bash
# Makes the files of the image: the daemon, the libraries that it is linked with, users, folders, and what all that is. There is
# no shell among them, nor any other program.
# usage: root.sh BUILD ROOT     (build/release, a directory that is not there yet); from the top of the tree
# Leaves to others: which libraries are on this machine (packages.txt), what runs it (Dockerfile, tests/rules/image.sh).
# Invariant: a library or loader that cannot be found, or that no Debian package holds, ends it.
set -eu -o pipefail
umask 022 # whoever runs it: what is written here is everybody's to read and nobody's to change
build=$1 root=$2
name=pendulumd uid=10001
mkdir "$root"
mkdir -p "$root"/{etc,proc,sys,dev,tmp,usr/local/bin,var/lib/dpkg/status.d,usr/share/doc/$name}
chmod 1777 "$root/tmp"
mkdir -m 700 "$root/var/lib/$name"
chown $uid:$uid "$root/var/lib/$name" 2>/dev/null || echo "root.sh: only root can give /var/lib/$name to user $uid" >&2

strip -o "$root/usr/local/bin/$name" "$build/$name"

# libgcc_s is loaded when a thread ends before its time, and by no name in the program
loaded=$(ldd "$build/$name")
if grep 'not found' <<<"$loaded" >&2; then exit 1; fi
loaded=$(grep -o '/[^ ]*' <<<"$loaded")
loaded+=$'\n'$(dirname "$(grep -m 1 'libc\.so' <<<"$loaded")")/libgcc_s.so.1
for library in $(sort -u <<<"$loaded"); do
    install -D -m 755 "$library" "$root$library"
done

# who owns them: older packages have a library in /lib, newer ones in /usr/lib, which is the same place. Scanners look for
# packages in status.d, and people for licences in doc.
packages=
for library in $(sort -u <<<"$loaded"); do
    package=$(dpkg -S "$library" 2>/dev/null || dpkg -S "/usr$library" 2>/dev/null || dpkg -S "${library#/usr}" 2>/dev/null) ||
        { echo "root.sh: no Debian package holds $library" >&2; exit 1; }
    packages+=$(sed -nE '1s/^([a-z0-9.+-]+)(:[a-z0-9]+)?: .*/\1/p' <<<"$package")$'\n'
done
packages=$(printf '%s\n' "$packages" | sort -u | sed '/^$/d')
[ "$(wc -l <<<"$packages")" -gt 10 ] || { echo "root.sh: that cannot be all packages: $packages" >&2; exit 1; }
for package in $packages; do
    dpkg-query -s "$package" | sed '/^Conffiles:/,/^[A-Z]/{/^Conffiles:/d; /^ /d}' > "$root/var/lib/dpkg/status.d/$package"
    install -D -m 644 "/usr/share/doc/$package/copyright" "$root/usr/share/doc/$package/copyright"
done
install -m 644 LICENSE "$root/usr/share/doc/$name/copyright"
docker/sbom.py "$build" "$root/usr/share/doc/$name" $packages

printf 'root:x:0:0:root:/:/nologin\n%s:x:%s:%s::/var/lib/%s:/nologin\n' $name $uid $uid $name > "$root/etc/passwd"
printf 'root:x:0:\n%s:x:%s:\n' $name $uid > "$root/etc/group"
# names of hosts: what the engine writes into /etc/hosts, then what it says of name servers
printf 'hosts: files dns\n' > "$root/etc/nsswitch.conf"
cp -L /etc/os-release "$root/etc/os-release"
