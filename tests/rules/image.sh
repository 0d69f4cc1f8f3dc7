#!/bin/bash
# Makes the files of the image, inspects them, runs the daemon with nothing else, and requests the paper's example; also builds
# the whole image and requests the same, if docker or buildah and the base of its first stages are here.
# usage: image.sh BUILD     (build/release)
# Leaves to others: whether the answer is right (tests/wire).
# Invariant: never waits for long, and leaves no container or image behind.
set -u
build=$1
image=pendulumd-check:$$
base=$(sed -n 's/^ARG DEBIAN_IMAGE=//p' docker/Dockerfile)
work=build/check/image
mkdir -p "$work"
container=
daemon=
passed=0

skip() { echo "skip image: $1"; echo "$passed passed, 0 failed, 1 skipped"; exit 0; }
fail() { echo "FAIL image: $1"; echo "$passed passed, 1 failed"; exit 1; }

# the example as it stands in the README; the address is the argument
ask() {
    curl -sS --max-time 20 -o "$work/answer" -w '%{http_code}' "http://$1/v1/trajectories" -H 'Content-Type: application/json' -d '{
        "pendulum": {"L": [2, 1.5, 0.75, 1.25], "m": [1, 1, 1, 0.1], "S": [[1,0,0,0], [1,1,0,0], [1,1,1,0], [1,1,0,1]]},
        "times": {"start": 0, "stop": 5, "step": 0.01}, "rtol": 1e-12}' || true
}

answered() { # address
    for _ in $(seq 1200); do
        [ "$(curl -s -o /dev/null -w '%{http_code}' --max-time 2 "http://$1/healthz")" = 200 ] && break
        sleep 0.1
    done
    status=$(ask "$1")
    [ "$status" = 200 ] && /usr/bin/python3 -c 'import json, sys; a = json.load(open(sys.argv[1])); sys.exit(len(a["phi"]) != 501)' "$work/answer"
}

with_docker() {
    local address health code
    docker image inspect "$base" >/dev/null 2>&1 || timeout 60 docker pull -q "$base" >/dev/null 2>&1 || skip "$base is not here and cannot be pulled"
    timeout 600 docker build -q -f docker/Dockerfile -t "$image" . || fail 'docker build'
    container=$(docker run -d --read-only --cap-drop ALL -p 127.0.0.1::8080 "$image") || fail 'docker run'
    trap 'docker rm -f "$container" >/dev/null 2>&1; docker rmi -f "$image" >/dev/null 2>&1' EXIT
    address=$(docker port "$container" 8080 | head -n 1)
    answered "$address" || fail "the example: status $status"
    for _ in $(seq 1200); do
        health=$(docker inspect -f '{{.State.Health.Status}}' "$container")
        [ "$health" = healthy ] && break
        sleep 0.1
    done
    [ "$health" = healthy ] || fail "its health is $health"
    docker stop -t 30 "$container" >/dev/null
    code=$(docker inspect -f '{{.State.ExitCode}}' "$container")
    [ "$code" = 0 ] || fail "it ended with $code"
}

# What a container of compose.yaml is, without an engine: the image's own user, settings and program on files that nobody can
# write, without capabilities; memory is mounted where the compose file has a volume. The process is the daemon itself.
confined() { # root, user, program, settings...
    exec unshare --mount bash -c '
        root=$1 user=$2 program=$3
        shift 3
        mount --bind "$root" "$root" && mount -o remount,bind,ro "$root" || exit 98
        for memory in /tmp /var/lib/pendulumd; do
            mount -t tmpfs -o "uid=$user,mode=700" tmpfs "$root$memory" || exit 98
        done
        mount -t proc proc "$root/proc" || exit 98
        if touch "$root/etc/written" 2>/dev/null; then exit 98; fi
        chroot=$(command -v chroot)
        exec env -i "$@" setpriv --no-new-privs "$chroot" "--userspec=$user:$user" --groups= "$root" "$program"' \
        confined "$@"
}

# the address that the daemon says it listens on
listens() {
    for _ in $(seq 1200); do
        address=$(sed -n 's|^listening on http://||p' "$work/log")
        [ -n "$address" ] && return
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.1
    done
    cat "$work/log"
    fail 'it does not listen'
}

# the confined daemon is who it should be, answers, keeps jobs, and ends
serves() { # user
    local code
    listens
    answered "$address" || fail "the example: status $status"
    status=$(curl -s -o /dev/null -w '%{http_code}' --max-time 10 "http://$address/readyz?need=jobs")
    [ "$status" = 200 ] || fail "it keeps no jobs: status $status"
    grep -qP "^Uid:(\t$1){4}$" "/proc/$daemon/status" || fail 'it runs as somebody else'
    grep -q '^CapPrm:[[:space:]]0*$' "/proc/$daemon/status" || fail 'it has capabilities'
    # as often as an engine does, on a machine that is busy
    for _ in 1 2 3; do "${healthy[@]}" "PENDULUMD_LISTEN=$address" && break; done || fail 'the health check says no'
    "${healthy[@]}" PENDULUMD_LISTEN=127.0.0.1:1 2>/dev/null && fail 'the health check says yes to nobody'
    kill -TERM "$daemon"
    wait "$daemon"
    code=$?
    [ "$code" = 0 ] || { cat "$work/log"; fail "it ended with $code"; }
}

# one word of the Dockerfile's last stage
dockerfile() { sed '1,/^FROM scratch/d' docker/Dockerfile | sed -nE "s/^$1 //p"; }

# what nobody may find in the image, and what everybody must
looks_right() { # root
    local bytes programs packages sbom
    bytes=$(du -sb "$1" | cut -f1)
    [ "$bytes" -lt 45000000 ] || fail "it has $bytes bytes"
    programs=$(find "$1" -type f -perm /111 ! -name '*.so*' ! -path "$1/usr/local/bin/pendulumd")
    [ -z "$programs" ] || fail "other programs: $programs"
    programs=$(find "$1" -perm /6000 -o -type f -perm /022)
    [ -z "$programs" ] || fail "rights of others: $programs"
    packages=$(ls "$1/var/lib/dpkg/status.d")
    for sbom in spdx cdx; do
        /usr/bin/python3 -c '
import json, sys
document = json.load(open(sys.argv[1]))
named = {part["name"] for part in document.get("packages") or document["components"]}
missing = [name for name in sys.argv[2:] if name not in named]
sys.exit(f"{sys.argv[1]} lacks {missing}" if missing else 0)' "$1/usr/share/doc/pendulumd/sbom.$sbom.json" $packages || fail "its SBOM, $sbom"
    done
    for package in $packages; do [ -s "$1/usr/share/doc/$package/copyright" ] || fail "the licence of $package"; done
    echo "the image's files: $bytes bytes, $(wc -w <<<"$packages") packages"
}

# Root may make a root of files, but not in every container.
may_mount() {
    mkdir -p "$work/mount"
    [ "$(id -u)" = 0 ] && unshare --mount bash -c '
        mount -t tmpfs tmpfs "$1" && mkdir "$1/proc" && mount -t proc proc "$1/proc" && mount --bind "$1" "$1" && mount -o remount,bind,ro "$1"' \
        may_mount "$work/mount" 2>/dev/null
}

# A library that no package holds ends the making of the files.
foreign() {
    mkdir -p "$work/foreign"
    cp "$(ldd "$build/pendulumd" | sed -nE 's/.*libcjson.* => ([^ ]*) .*/\1/p')" "$work/foreign"
    rm -rf "$work/foreign root"
    LD_LIBRARY_PATH=$PWD/$work/foreign docker/root.sh "$build" "$work/foreign root" >"$work/log" 2>&1 && fail 'a library of nobody is in it'
    grep -q 'no Debian package holds .*libcjson' "$work/log" || { cat "$work/log"; fail 'a library of nobody is not named'; }
    rm -rf "$work/foreign" "$work/foreign root"
}

# The files alone, which takes no engine.
with_files() {
    local root=$work/root user
    user=$(dockerfile USER)
    rm -rf "$root"
    docker/root.sh "$build" "$root" >"$work/log" 2>&1 || { cat "$work/log"; fail 'its files'; }
    looks_right "$root"
    foreign
    if may_mount; then
        trap 'kill $daemon 2>/dev/null' EXIT
        : >"$work/log"
        confined "$PWD/$root" "$user" "$(dockerfile ENTRYPOINT | tr -d '[]"')" $(dockerfile ENV) PENDULUMD_LISTEN=127.0.0.1:0 >"$work/log" 2>&1 &
        daemon=$!
        healthy=(within "$PWD/$root" "$user")
        serves "$user"
        trap - EXIT
    fi
    rm -rf "$root"
    passed=$((passed + 1))
}

# the health check of the Dockerfile on the files alone, with a setting
within() { # root, user, setting
    local check
    check=$(sed -nE 's/^HEALTHCHECK .* CMD \[(.*)\]$/\1/p' docker/Dockerfile | tr -d '",')
    env -i "$3" "$(command -v chroot)" "--userspec=$2:$2" --groups= "$1" $check
}

# Without an engine: everything in a chroot on the host's network, so the daemon gets a free port of loopback. Who is not root
# cannot mount, and has buildah run it.
with_buildah() {
    local settings
    export BUILDAH_ISOLATION=${BUILDAH_ISOLATION:-chroot} STORAGE_DRIVER=${STORAGE_DRIVER:-vfs}
    buildah inspect --type image "$base" >/dev/null 2>&1 || timeout 60 buildah pull -q "$base" >/dev/null 2>&1 || skip "$base is not here and cannot be pulled"
    timeout "${IMAGE_SECONDS:-600}" buildah bud --format docker --pull-never --layers=false -q -f docker/Dockerfile -t "$image" . || fail 'buildah bud'
    container=$(buildah from --pull-never "$image") || fail 'buildah from'
    trap 'kill $daemon 2>/dev/null; buildah umount "$container" >/dev/null 2>&1; buildah rm "$container" >/dev/null 2>&1; buildah rmi -f "$image" >/dev/null 2>&1' EXIT
    [ "$(buildah inspect --format '{{.OCIv1.Config.User}}' "$container")" = 10001 ] || fail 'it runs as somebody else'
    if [ "$(id -u)" = 0 ]; then
        looks_right "$(buildah mount "$container")"
        mapfile -t settings < <(buildah inspect --format '{{range .OCIv1.Config.Env}}{{println .}}{{end}}' "$container" | grep =)
        confined "$(buildah mount "$container")" 10001 "$(buildah inspect --format '{{index .OCIv1.Config.Entrypoint 0}}' "$container")" \
            "${settings[@]}" PENDULUMD_LISTEN=127.0.0.1:0 >"$work/log" 2>&1 &
        daemon=$!
        healthy=(within "$(buildah mount "$container")" 10001)
        serves 10001
    else
        buildah run --env PENDULUMD_LISTEN=127.0.0.1:0 "$container" -- /usr/local/bin/pendulumd >"$work/log" 2>&1 &
        daemon=$!
        listens
        answered "$address" || fail "the example: status $status"
        buildah run --env "PENDULUMD_LISTEN=$address" "$container" -- /usr/local/bin/pendulumd healthy || fail 'the health check says no'
    fi
}

with_files
if timeout 10 docker info >/dev/null 2>&1; then
    with_docker
elif command -v buildah >/dev/null; then
    with_buildah
else
    skip 'neither a docker engine nor buildah is here'
fi
echo "$((passed + 1)) passed, 0 failed"
