#!/bin/bash
# Runs one job of `make check`, prints how it ended, and keeps its count; or adds up the counts of all.
# usage: job.sh NAME COMMAND...  |  job.sh --sum
# Leaves to others: what the jobs are (check.mk).
# Invariant: a job's count is its last line `N passed, N failed[, N skipped]`; without one, its exit status is the count.
set -u
out=build/check
count_line='^[0-9]+ passed, [0-9]+ failed(, [0-9]+ skipped)?$'

# the three numbers of a count line
numbers() { sed -E 's/ passed, / /; s/ failed,? ?/ /; s/ skipped//' <<<"$1"; }

sum() {
    local passed=0 failed=0 skipped=0 p f s line bad=()
    for name in $(cat "$out/jobs"); do
        line=$(cat "$out/$name.count" 2>/dev/null) || line='0 passed, 1 failed'
        read -r p f s <<<"$(numbers "$line")"
        passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + ${s:-0}))
        [ "$f" = 0 ] || bad+=("$name")
    done
    [ ${#bad[@]} = 0 ] || printf '\nFailed: %s  (the whole output of each is in %s/NAME.log)\n' "${bad[*]}" "$out"
    printf '%d passed, %d failed' "$passed" "$failed"
    [ $skipped = 0 ] || printf ', %d skipped' "$skipped"
    printf '\n'
    [ "$failed" = 0 ] && [ "$passed" -gt 0 ]
}

run() {
    local name=$1 status line p f s worked begin=$EPOCHREALTIME
    shift
    mkdir -p "$out"
    timeout -k 20 3600 "$@" >"$out/$name.log" 2>&1 </dev/null
    status=$?
    times >"$out/$name.times"
    worked=$(awk 'NR == 2 { split($1, user, "m"); split($2, sys, "m"); print 60 * (user[1] + sys[1]) + user[2] + sys[2] }' \
        "$out/$name.times")
    line=$(tail -n 1 "$out/$name.log" | grep -E "$count_line") || line=
    if [ -z "$line" ]; then
        # a build has no count of its own: that it went through without a warning is one check
        if [ $status = 0 ] && [[ $name = build-* ]]; then line='1 passed, 0 failed'; else line='0 passed, 1 failed'; fi
    fi
    read -r p f s <<<"$(numbers "$line")"
    [ $status = 0 ] || [ "$f" -gt 0 ] || line="$p passed, 1 failed${s:+, $s skipped}"
    printf '%s\n' "$line" >"$out/$name.count.new" && mv "$out/$name.count.new" "$out/$name.count"
    report "$name" "$status" "$line" "$begin" "$worked"
}

# one line a job, with its seconds and those that processors spent on it; below it what failed and what was skipped
report() {
    local word=ok seconds
    seconds=$(awk -v begin="$4" -v end="$EPOCHREALTIME" 'BEGIN { printf "%.1f", end - begin }')
    [[ $3 = *' 0 failed'* ]] || word=FAIL
    {
        printf '%-4s %-15s %s  (%s s, %.1f s of processors)\n' $word "$1" "$3" "$seconds" "$5"
        grep '^skip' "$out/$1.log" | sed 's/^/       /'
        if [ $word = FAIL ]; then
            printf '       exit status %d; the end of %s/%s.log:\n' "$2" "$out" "$1"
            { grep -n -B 6 '^FAIL' "$out/$1.log" | head -n 60; tail -n 25 "$out/$1.log"; } | sed 's/^/       | /'
        fi
    } >"$out/$1.report"
    cat "$out/$1.report"
}

if [ "$1" = --sum ]; then sum; else run "$@"; fi
