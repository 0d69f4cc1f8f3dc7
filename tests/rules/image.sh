#!/bin/bash
# Builds the image, starts it, and asks it for the paper's example, where docker or buildah and the base image are here.
# Leaves to others: what is right in the answer (tests/wire).
# Invariant: never waits for long, and leaves no container and no image behind.
set -u
image=pendulumd-check:$$
base=$(sed -n 's/^ARG DEBIAN_IMAGE=//p' docker/Dockerfile)
work=build/check/image
mkdir -p "$work"
container=
daemon=

skip() { echo "skip image: $1"; echo '0 passed, 0 failed, 1 skipped'; exit 0; }
fail() { echo "FAIL image: $1"; echo '0 passed, 1 failed'; exit 1; }

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
confined() { # listening address
    local image_user image_program image_settings
    image_user=$(buildah inspect --format '{{.OCIv1.Config.User}}' "$container")
    image_program=$(buildah inspect --format '{{index .OCIv1.Config.Entrypoint 0}}' "$container")
    mapfile -t image_settings < <(buildah inspect --format '{{range .OCIv1.Config.Env}}{{println .}}{{end}}' "$container" | grep =)
    exec unshare --mount bash -c '
        root=$1 user=$2
        shift 2
        mount --bind "$root" "$root" && mount -o remount,bind,ro "$root" || exit 98
        for memory in /tmp /var/lib/pendulumd; do
            mount -t tmpfs -o "uid=$user,mode=700" tmpfs "$root$memory" || exit 98
        done
        mount -t proc proc "$root/proc" || exit 98
        if touch "$root/etc/written" 2>/dev/null; then exit 98; fi
        exec chroot "$root" setpriv --reuid "$user" --regid "$user" --clear-groups --no-new-privs --bounding-set=-all \
            --inh-caps=-all env -i "$@"' \
        confined "$(buildah mount "$container")" "$image_user" "${image_settings[@]}" "PENDULUMD_LISTEN=$1" "$image_program"
}

# Without an engine: everything in a chroot on the host's network, so the daemon gets a free port of loopback. Who is not root
# cannot mount, and has buildah run it.
with_buildah() {
    local address code
    export BUILDAH_ISOLATION=${BUILDAH_ISOLATION:-chroot} STORAGE_DRIVER=${STORAGE_DRIVER:-vfs}
    buildah inspect --type image "$base" >/dev/null 2>&1 || timeout 60 buildah pull -q "$base" >/dev/null 2>&1 || skip "$base is not here and cannot be pulled"
    timeout 600 buildah bud --format docker --pull-never --layers=false -q -f docker/Dockerfile -t "$image" . || fail 'buildah bud'
    container=$(buildah from --pull-never "$image") || fail 'buildah from'
    trap 'kill $daemon 2>/dev/null; buildah umount "$container" >/dev/null 2>&1; buildah rm "$container" >/dev/null 2>&1; buildah rmi -f "$image" >/dev/null 2>&1' EXIT
    [ "$(buildah run "$container" -- id -u)" = 10001 ] || fail 'it runs as somebody else'
    if [ "$(id -u)" = 0 ]; then
        confined 127.0.0.1:0 >"$work/log" 2>&1 &
    else
        buildah run --env PENDULUMD_LISTEN=127.0.0.1:0 "$container" -- /usr/local/bin/pendulumd >"$work/log" 2>&1 &
    fi
    daemon=$!
    for _ in $(seq 1200); do
        address=$(sed -n 's|^listening on http://||p' "$work/log")
        [ -n "$address" ] && break
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.1
    done
    [ -n "$address" ] || { cat "$work/log"; fail 'it does not listen'; }
    answered "$address" || fail "the example: status $status"
    status=$(curl -s -o /dev/null -w '%{http_code}' --max-time 10 "http://$address/readyz?need=jobs")
    [ "$status" = 200 ] || fail "it keeps no jobs: status $status"
    buildah run --env "PENDULUMD_LISTEN=$address" "$container" -- /usr/local/bin/healthy || fail 'the health check says no'
    buildah run --env PENDULUMD_LISTEN=127.0.0.1:1 "$container" -- /usr/local/bin/healthy 2>/dev/null && fail 'the health check says yes to nobody'
    [ "$(id -u)" = 0 ] || return 0
    grep -q '^CapPrm:[[:space:]]0*$' "/proc/$daemon/status" || fail 'it has capabilities'
    kill -TERM "$daemon"
    wait "$daemon"
    code=$?
    [ "$code" = 0 ] || { cat "$work/log"; fail "it ended with $code"; }
}

if timeout 10 docker info >/dev/null 2>&1; then
    with_docker
elif command -v buildah >/dev/null; then
    with_buildah
else
    skip 'neither a docker engine nor buildah is here'
fi
echo '1 passed, 0 failed'
