#!/bin/sh
# Runs a fuzzer for a time and tells what it did: executions, edges and inputs, and the executions
# of all runs whose counts lie beside its corpus.
#   tests/fuzz/run.sh PROGRAM SECONDS
# The output of the last run is PROGRAM.log; an input that ends the program lies beside it.
set -u
program=$1 seconds=$2
mkdir -p "$program.corpus"
status=0
"$program" -max_total_time="$seconds" -max_len=16384 -print_final_stats=1 \
  -artifact_prefix="$(dirname "$program")/" "$program.corpus" > "$program.log" 2>&1 || status=$?
[ $status = 0 ] || grep -v '^#' "$program.log" | tail -n 60
executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$program.log")
if [ -n "$executions" ]; then
  echo "$executions" >> "$program.counts"
  sed -n 's/^#[0-9]*[[:space:]].* cov: \([0-9]*\) ft: [0-9]* corp: \([0-9]*\)\/.*/\1 edges, \2 inputs/p' \
    "$program.log" | tail -n 1 | awk -v name="$(basename "$program")" -v now="$executions" \
    -v all="$(awk '{ sum += $1 } END { printf "%.0f", sum }' "$program.counts")" \
    '{ print name ": " now " executions, " $0 "; " all " executions in all runs" }'
elif [ $status = 0 ]; then
  echo "$program has told no count: $program.log" >&2
  status=1
fi
exit $status
