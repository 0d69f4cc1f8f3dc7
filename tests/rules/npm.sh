# Brings the npm packages of a package.json, once: for rules that need a tool from npm; to be sourced.
# usage: fetch_packages FROM HOME     (the directory of package.json and package-lock.json; a directory in build/)
# Leaves to others: what is said where it fails (a rule skips itself with words).
# Invariant: what npm fetches lies in build/, whole; two at once do it once; the lock file's digests are checked by npm.
fetch_packages() {
    local from=$1 home=$2
    command -v npm >/dev/null || return
    mkdir -p build
    exec 8>"$home.lock"
    flock 8
    cmp -s "$from/package-lock.json" "$home/package-lock.json" && return
    rm -rf "$home.new" && mkdir -p "$home.new" && cp "$from/package.json" "$from/package-lock.json" "$home.new"
    timeout 240 npm ci --ignore-scripts --prefix "$home.new" --cache build/npm --no-audit --no-fund --no-update-notifier \
        --silent >/dev/null 2>&1 || return
    rm -rf "$home" && mv "$home.new" "$home"
}
