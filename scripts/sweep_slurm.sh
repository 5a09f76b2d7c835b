#!/usr/bin/env bash
# The sweep of scripts/sweep.sh as a Slurm job array, one task a run, and a job that writes the table when all tasks have ended.
#
#   scripts/sweep_slurm.sh SCENARIO.toml FOLDER 'KEY=VALUE VALUE…' ['KEY=VALUE VALUE…']…
#
# FOLDER must be on a disk that all nodes see. Called again, it submits what is not done. Prints the numbers of both jobs.
#
# Environment: FBIMPACT, THREADS as for sweep.sh (THREADS is also the number of CPUs asked for)
#              JOBS           tasks at a time (default: as many as Slurm allows)
#              SBATCH_EXTRA   further options of sbatch, such as "--partition=short --time=10:00 --mem=2G"
set -euo pipefail

if [ $# -lt 3 ]; then
    printf 'usage: sweep_slurm.sh SCENARIO.toml FOLDER KEY=VALUE…\n' >&2
    exit 2
fi
# Tasks get all names in their environment: there is nothing that a shell could take for something else.
export SWEEP SWEEP_SCENARIO SWEEP_FOLDER SWEEP_TODO
SWEEP=$(cd -- "$(dirname -- "$0")" && pwd)/sweep.sh
SWEEP_SCENARIO=$(realpath -- "$1")
SWEEP_FOLDER=$(realpath -m -- "$2")
export FBIMPACT=${FBIMPACT:-fbimpact} THREADS=${THREADS:-1}
shift 2
"$SWEEP" --plan "$SWEEP_SCENARIO" "$SWEEP_FOLDER" "$@"

# The list of this call is its own: a later call does not change what waiting tasks do.
SWEEP_TODO=$(mktemp "$SWEEP_FOLDER/todo.XXXXXX")
"$SWEEP" --todo "$SWEEP_SCENARIO" "$SWEEP_FOLDER" >"$SWEEP_TODO"
n=$(wc -l <"$SWEEP_TODO")

read -ra extra <<<"${SBATCH_EXTRA:-}"
common=(--parsable --export=ALL --chdir="${PWD//%/%%}" "${extra[@]}")
depend=()
if [ "$n" -gt 0 ]; then
    # shellcheck disable=SC2016  # for the task to fill in
    array=$(sbatch "${common[@]}" --job-name=fbimpact --array="1-$n${JOBS:+%$JOBS}" --cpus-per-task="$THREADS" --output=/dev/null \
        --wrap 'exec "$SWEEP" --one "$SWEEP_SCENARIO" "$SWEEP_FOLDER" "$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$SWEEP_TODO")"')
    depend=(--dependency="afterany:$array")
    printf 'array of %s runs: job %s\n' "$n" "$array"
else
    rm -f -- "$SWEEP_TODO"
fi
# shellcheck disable=SC2016
table=$(sbatch "${common[@]}" --job-name=fbimpact-table "${depend[@]}" --output="${SWEEP_FOLDER//%/%%}/table.log" \
    --wrap 'exec "$SWEEP" --collect "$SWEEP_FOLDER"')
printf 'table: job %s, writes %q\n' "$table" "$SWEEP_FOLDER/table.csv"
