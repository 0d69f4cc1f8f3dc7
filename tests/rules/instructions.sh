#!/bin/bash
# Counts the instructions of the hot loops, and compares them with the recorded counts.
# usage: instructions.sh BUILD     (build/release)
# Leaves to others: times (make bench), the results of the loops.
# Invariant: a loop that became much cheaper also fails, until its new count is recorded here.
set -u
program=$1/tests/bench/instructions/run
slack=20 # percent: what compilers differ by

# function, arms times states times steps that it runs, instructions for each with avx2
figures='
count_one          1024  109
count_lanes        1024   43
count_taylor_small  200 1890
count_taylor_large 2000 3765
'
skip() { echo "$1"; echo "0 passed, 0 failed, $(grep -c count_ <<<"$figures") skipped"; exit 0; }

command -v valgrind callgrind_annotate >/dev/null || skip 'valgrind is not installed'
[ "$(uname -m)" = x86_64 ] || skip 'the figures are those of x86_64'
out=$(mktemp) || exit 1
trap 'rm -f "$out"' EXIT
said=$(valgrind -q --tool=callgrind --callgrind-out-file="$out" "$program" 2>&1) || { echo "$said"; exit 1; }
[ "$said" = 'no avx2' ] && skip 'valgrind runs no AVX2 here'
counts=$(callgrind_annotate --inclusive=yes --threshold=100 "$out" | sed -nE 's/^ *([0-9,]+) .*:(count_[a-z_]+).*/\2 \1/p' | tr -d ,)
passed=0 failed=0
while read -r name divisor want; do
    got=$(awk -v name="$name" -v divisor="$divisor" '$1 == name { printf "%.1f", $2 / divisor; exit }' <<<"$counts")
    printf '%-20s %8s instructions, was %s\n' "$name" "${got:-no}" "$want"
    if awk -v got="${got:-0}" -v want="$want" -v slack=$slack 'BEGIN { exit !(got > 0 && got < want * (1 + slack / 100) && got > want * (1 - slack / 100)) }'; then
        passed=$((passed + 1))
    else
        echo "FAIL $name: more than $slack percent away"
        failed=$((failed + 1))
    fi
done < <(grep count_ <<<"$figures")
echo "$passed passed, $failed failed"
