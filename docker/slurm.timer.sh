#!/bin/bash
# Starts Slurm workers while parts of jobs wait: for a timer, such as `* * * * * docker/slurm.timer.sh` in a crontab.
#   PENDULUMD_STORE=postgresql://pendulumd@db.example.org/pendulumd MOST=32 docker/slurm.timer.sh
# One worker for each PARTS (16) that wait, MOST (8) at most, those that run or are queued counted. Needs psql and sbatch.
set -eu
: "${PENDULUMD_STORE:?must be postgresql://...}"
here=$(dirname "$0")
waiting=$(psql -XAtq "$PENDULUMD_STORE" -c 'SELECT GREATEST(COALESCE(SUM(waiting), 0), 0) FROM totals')
wanted=$(((waiting + ${PARTS:-16} - 1) / ${PARTS:-16}))
[ "$wanted" -le "${MOST:-8}" ] || wanted=${MOST:-8}
there=$(squeue -h -r -n pendulumd -t PENDING,RUNNING,CONFIGURING -o %i | wc -l)
[ "$wanted" -gt "$there" ] || exit 0
sbatch --array="1-$((wanted - there))" "$here/slurm.sbatch"
