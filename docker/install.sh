#!/bin/sh
# Installs the Debian packages of packages.txt that are missing, and says what and why.
# usage: install.sh PURPOSE...     (the first column of packages.txt: build, client, engine, test, ...)
# Leaves to others: what is needed (packages.txt).
# Invariant: does nothing, prints nothing and asks nothing when all are there.
set -eu
list=$(dirname "$0")/packages.txt

# true when a package is there: its command is on the path, or dpkg has it installed, or one that provides it
there() {
    if [ "$2" != - ]; then
        command -v "$2" >/dev/null && return
    fi
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ] ||
        dpkg-query -W -f '${db:Status-Status}, ${Provides},\n' 2>/dev/null | grep '^installed,' | grep -qF -e ", $1," -e ", $1 ("
}

rows() {
    for purpose; do grep "^$purpose " "$list"; done
}

missing=$(rows "$@" | while read -r purpose package proof reason; do
    there "$package" "$proof" || printf '%s\t%s\n' "$package" "$reason"
done)
[ -n "$missing" ] || exit 0
names=$(printf '%s\n' "$missing" | cut -f1 | tr '\n' ' ')

if ! command -v apt-get >/dev/null; then
    printf 'This system has no apt-get. Install what it calls these Debian packages yourself: %s\n' "$names" >&2
    exit 0
fi
printf 'Installing the Debian packages that are missing (two minutes or so for what builds the server, more for what tests it):\n'
printf '%s\n' "$missing" | while IFS="$(printf '\t')" read -r package reason; do
    printf '  %-20s %s\n' "$package" "$reason"
done

sudo=
if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null; then
        printf 'This needs root. As root, run:  apt-get install %s\n' "$names" >&2
        exit 1
    fi
    sudo='sudo'
    printf 'sudo may ask for your password.\n'
fi

apt() {
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=120 "$@" </dev/null
}

# apt's own chatter goes to a file that is shown when something fails
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { apt update && apt install -y --no-install-recommends $names; } >"$log" 2>&1; then
    cat "$log" >&2
    printf 'apt-get failed (see above). By hand:  apt-get install %s\n' "$names" >&2
    exit 1
fi
