#!/bin/bash
# Runs one job of `make check`, prints how it ended, and keeps its count; or adds up the counts of all.
# usage: job.sh NAME COMMAND...  |  job.sh --sum
# Leaves to others: what the jobs are (check.mk).
# Invariant: a job's count is its last line `N passed, N failed[, N skipped][, N passed at the second try]`; without one, its exit
# status is the count. What passed at the second try only is counted among what passed, and named in the report and the sum.
set -u
out=build/check
count_line='^[0-9]+ passed, [0-9]+ failed(, [0-9]+ skipped)?(, [0-9]+ passed at the second try)?$'

# the four numbers of a count line: passed, failed, skipped, passed at the second try
numbers() {
    awk -F ', ' '{
        for (i = 3; i <= NF; i++) {
            if ($i ~ / skipped$/) skipped = $i + 0
            else second = $i + 0
        }
        print $1 + 0, $2 + 0, skipped + 0, second + 0
    }' <<<"$1"
}

# a count line of four numbers
line_of() {
    printf '%d passed, %d failed' "$1" "$2"
    [ "$3" = 0 ] || printf ', %d skipped' "$3"
    [ "$4" = 0 ] || printf ', %d passed at the second try' "$4"
    printf '\n'
}

# the ten jobs that took the most processor time, where there were more
dearest() {
    local reports=()
    for name in $(cat "$out/jobs"); do [ ! -f "$out/$name.report" ] || reports+=("$out/$name.report"); done
    [ ${#reports[@]} -gt 10 ] || return 0
    printf '\nThe ten jobs that took most, in seconds of processors, and in seconds:\n'
    sed -nE -s '1s/^[A-Za-z]+ +([^ ]+) .*\(([0-9.]+) s, ([0-9.]+) s of processors\)$/\3 \2 \1/p' "${reports[@]}" |
        sort -rn | head -n 10 | awk '{ printf "  %8.1f %8.1f  %s\n", $1, $2, $3 }'
}

sum() {
    local passed=0 failed=0 skipped=0 second=0 p f s a line bad=()
    for name in $(cat "$out/jobs"); do
        line=$(cat "$out/$name.count" 2>/dev/null) || line='0 passed, 1 failed'
        read -r p f s a <<<"$(numbers "$line")"
        passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s)) second=$((second + a))
        [ "$f" = 0 ] || bad+=("$name")
    done
    dearest
    [ ${#bad[@]} = 0 ] || printf '\nFailed: %s  (the whole output of each is in %s/NAME.log)\n' "${bad[*]}" "$out"
    line_of "$passed" "$failed" "$skipped" "$second"
    [ "$failed" = 0 ] && [ "$passed" -gt 0 ]
}

run() {
    local name=$1 status line p f s a worked begin=$EPOCHREALTIME
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
    read -r p f s a <<<"$(numbers "$line")"
    [ $status = 0 ] || [ "$f" -gt 0 ] || line=$(line_of "$p" 1 "$s" "$a")
    printf '%s\n' "$line" >"$out/$name.count.new" && mv "$out/$name.count.new" "$out/$name.count"
    report "$name" "$status" "$line" "$begin" "$worked"
}

# one line a job, with its seconds and those that processors spent on it; below it what failed, what was skipped, what took a second try
report() {
    local word=ok seconds
    seconds=$(awk -v begin="$4" -v end="$EPOCHREALTIME" 'BEGIN { printf "%.1f", end - begin }')
    [[ $3 = *' 0 failed'* ]] || word=FAIL
    {
        printf '%-4s %-15s %s  (%s s, %.1f s of processors)\n' $word "$1" "$3" "$seconds" "$5"
        grep -E '^(skip|second)' "$out/$1.log" | sed 's/^/       /'
        if [ $word = FAIL ]; then
            printf '       exit status %d; the end of %s/%s.log:\n' "$2" "$out" "$1"
            { grep -n -B 6 '^FAIL' "$out/$1.log" | head -n 60; tail -n 25 "$out/$1.log"; } | sed 's/^/       | /'
        fi
    } >"$out/$1.report"
    cat "$out/$1.report"
}

if [ "$1" = --sum ]; then sum; else run "$@"; fi
