#!/bin/bash
# Runs a room's test program under valgrind; of wire, the daemon that it talks to.
# usage: valgrind.sh BUILD ROOM [PART-OF-A-NAME...]     without names: the tests that were quick in the release run
# Leaves to others: the numbers; valgrind computes long double in 64 bits, so only what it says itself counts here.
# Invariant: a wrong access, a decision on an unset value, or a leak fails the run; so does a program that breaks off.
set -u
build=$1 room=$2
shift 2
valgrind="valgrind -q --suppressions=tests/harness/valgrind.supp --fair-sched=try --error-exitcode=99 --leak-check=full --show-leak-kinds=definite,indirect,possible"
log=build/check/release-$room.log

# Name and seconds of the tests that passed, quickest first, until the sum reaches a twelfth of a second. Loops over failing
# allocations repeat one call hundreds of times: the address sanitizer runs them, and the release run, on memory full of nonsense.
quick() { grep -v allocation_faults "$log" | sed -nE 's/^ok +([^ ]+) \(([0-9.]+) s, .*/\2 \1/p' | sort -n | awk '(sum += $1) < 0.08 { print "=" $2 }'; }

if [ $room = wire ]; then
    TEST_UNDER=$valgrind exec "$build/tests/wire/run" "$@"
fi
if [ $# = 0 ]; then
    set -- $(quick)
    [ $# -gt 0 ] || { echo "no times in $log"; exit 1; }
fi
out=$($valgrind "$build/tests/$room/run" "$@" 2>&1)
status=$?
printf '%s\n' "$out" | sed '$d'
last=$(tail -n 1 <<<"$out")
ran=$(awk '/ passed, / { print $1 + $3 }' <<<"$last")
if [ $status = 99 ] || [ -z "$ran" ] || grep -q '^==[0-9]*==' <<<"$out"; then echo "$last"; echo '0 passed, 1 failed'; exit 1; fi
echo "$ran passed, 0 failed"
