#!/usr/bin/env bash
# The sweep of scripts/sweep.sh as a Slurm job array, one task a run, and a job that writes the table when all tasks have ended.
#
#   scripts/sweep_slurm.sh SCENARIO.toml FOLDER 'KEY=VALUE VALUE…' ['KEY=VALUE VALUE…']…
#
# FOLDER must be on a disk that all nodes see. Called again, it submits what is not complete. Prints the numbers of both jobs.
#
# Environment: FBIMPACT, THREADS as for sweep.sh (THREADS is also the number of CPUs asked for)
#              JOBS           tasks at a time (default: as many as Slurm allows)
#              SBATCH_EXTRA   further options of sbatch, such as "--partition=short --time=10:00 --mem=2G"
set -euo pipefail

sweep=$(cd "$(dirname "$0")" && pwd)/sweep.sh
if [ $# -lt 3 ]; then
    printf 'usage: sweep_slurm.sh SCENARIO.toml FOLDER KEY=VALUE…\n' >&2
    exit 2
fi
scenario=$(realpath "$1")
folder=$(realpath -m "$2")
shift 2
"$sweep" --plan "$scenario" "$folder" "$@"

: >"$folder/todo"
while IFS= read -r name; do
    [ -f "$folder/$name.h5" ] && [ "$(cat "$folder/$name.exit" 2>/dev/null)" = 0 ] || printf '%s\n' "$name" >>"$folder/todo"
done <"$folder/plan"
n=$(wc -l <"$folder/todo")

export FBIMPACT=${FBIMPACT:-fbimpact} THREADS=${THREADS:-1}
read -ra extra <<<"${SBATCH_EXTRA:-}"
common=(--parsable --export=ALL --chdir="$PWD" "${extra[@]}")
depend=()
if [ "$n" -gt 0 ]; then
    # The list of this call is kept apart: a later call does not change what waiting tasks do.
    list=$(mktemp "$folder/todo.XXXXXX")
    mv "$folder/todo" "$list"
    # shellcheck disable=SC2016  # the task number is for the task to fill in
    array=$(sbatch "${common[@]}" --job-name=fbimpact --array="1-$n${JOBS:+%$JOBS}" --cpus-per-task="$THREADS" --output=/dev/null \
        --wrap "$(printf '%q --one %q %q "$(sed -n "${SLURM_ARRAY_TASK_ID}p" %q)"' "$sweep" "$scenario" "$folder" "$list")")
    depend=(--dependency="afterany:$array")
    printf 'array of %s runs: job %s\n' "$n" "$array"
fi
table=$(sbatch "${common[@]}" --job-name=fbimpact-table "${depend[@]}" --output="$folder/table.log" \
    --wrap "$(printf '%q --collect %q' "$sweep" "$folder")")
printf 'table: job %s, writes %s/table.csv\n' "$table" "$folder"
