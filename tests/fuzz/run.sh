#!/bin/sh
# Runs each reader under libFuzzer for some seconds, and prints its executions, edges and inputs,
# and its executions in all runs so far.
#   tests/fuzz/run.sh build/fuzz-MODE SECONDS [READER]
# FUZZ_EXECUTIONS=N ends a reader after N executions, FUZZ_LENGTH=BYTES limits its inputs (4096).
# The inputs of a reader are in build/fuzz-MODE/corpus/READER and begin with those of tests/fuzz/corpus;
# READER.log is libFuzzer's last output, READER.counts the executions of each run. An input that crashes
# the program is READER-crash-...: `tests/fuzz/corpus.py add READER FILE` adds it to the repository.
set -u
build=$1 seconds=$2 only=${3:-}
here=$(dirname "$0") status=0 found=0
for program in "$build"/fuzz_*; do
  case $program in *.*) continue ;; esac
  for reader in $(FUZZ_READER='' "$program"); do
    [ -z "$only" ] || [ "$only" = "$reader" ] || continue
    found=1
    corpus=$build/corpus/$reader log=$build/corpus/$reader.log counts=$build/corpus/$reader.counts
    mkdir -p "$corpus"
    /usr/bin/python3 -B "$here/corpus.py" unpack "$reader" "$corpus" || exit
    FUZZ_READER=$reader FUZZ_SEEDS=$corpus "$program" -max_total_time="$seconds" -max_len="${FUZZ_LENGTH:-4096}" \
      -runs="${FUZZ_EXECUTIONS:--1}" -print_final_stats=1 -artifact_prefix="$build/corpus/$reader-" "$corpus" > "$log" 2>&1 ||
      { status=1; grep -v '^#' "$log" | tail -n 60; }
    # the last line of an interrupted run contains its number of executions
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    [ -n "$executions" ] || executions=$(sed -n 's/^#\([0-9]*\).*/\1/p' "$log" | tail -n 1)
    echo "${executions:-0}" >> "$counts"
    sed -n 's/^#[0-9]*[[:space:]].* cov: \([0-9]*\) ft: [0-9]* corp: \([0-9]*\)\/.*/\1 edges, \2 inputs/p' "$log" |
      tail -n 1 | awk -v name="$reader" -v now="${executions:-0}" \
      -v all="$(awk '{ sum += $1 } END { printf "%.0f", sum }' "$counts")" \
      '{ print name ": " now " executions, " $0 "; " all " executions in all runs" }'
  done
done
[ $found = 1 ] || { echo "there is no reader $only in $build" >&2; status=1; }
exit $status
