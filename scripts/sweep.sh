#!/usr/bin/env bash
# Runs a scenario with all combinations of values, several at a time, and gathers the results in one table.
#
#   scripts/sweep.sh SCENARIO.toml FOLDER 'KEY=VALUE VALUE…' ['KEY=VALUE VALUE…']…
#
#   scripts/sweep.sh scenarios/sphere_on_plane.toml sweep \
#       'bodies.ball.velocity=[0,0,-0.05] [0,0,-0.1]' 'materials.aluminium.youngs_modulus=70e9 72.8e9 75e9'
#
# Values are separated by spaces and contain none. Every run leaves in FOLDER, under a name made from its values,
#   <run>.set   its KEY=VALUE lines      <run>.exit   its exit code
#   <run>.h5    its result               <run>.log    what it said
# and the table is FOLDER/table.csv and FOLDER/table.h5. Called again, it does what is missing: complete runs are skipped, killed ones
# go on, failed ones are tried again, added values are added. One failed run stops no other; the exit code is then 1.
#
# Environment: FBIMPACT  the program (default: fbimpact)       JOBS     runs at a time (default: number of cores)
#              THREADS   threads of a run (default: 1)         RUNNER   parallel or xargs (default: GNU parallel if there)
#
# For schedulers: `--plan SCENARIO FOLDER KEY=…` only writes the .set files and FOLDER/plan, one run a line;
# `--one SCENARIO FOLDER RUN` does one run; `--collect FOLDER` writes the table.
set -euo pipefail

FBIMPACT=${FBIMPACT:-fbimpact}
THREADS=${THREADS:-1}
JOBS=${JOBS:-$(nproc 2>/dev/null || echo 1)}

fail() {
    printf 'sweep.sh: %s\n' "$1" >&2
    exit 2
}

# Prints every combination: its KEY=VALUE lines, then an empty line.
combinations() {
    local prefix=$1
    shift
    if [ $# -eq 0 ]; then
        printf '%s\n' "$prefix"
        return
    fi
    local key=${1%%=*} values value
    read -ra values <<<"${1#*=}"
    shift
    for value in "${values[@]}"; do
        combinations "$prefix$key=$value"$'\n' "$@"
    done
}

# Writes FOLDER/plan and a .set file for each run.
plan() {
    local scenario=$1 folder=$2 spec sum block name
    shift 2
    [ -f "$scenario" ] || fail "$scenario: no such scenario"
    for spec in "$@"; do
        [[ $spec == ?*=* && -n ${spec#*=} ]] || fail "'$spec' is not KEY=VALUE VALUE…"
    done
    mkdir -p "$folder"
    sum=$(sha256sum <"$scenario")
    if [ -e "$folder/scenario.sha256" ] && [ "$(cat "$folder/scenario.sha256")" != "$sum" ]; then
        fail "$scenario has changed since $folder was begun, use another folder"
    fi
    printf '%s\n' "$sum" >"$folder/scenario.sha256"
    : >"$folder/plan.new"
    block=
    while IFS= read -r line; do
        if [ -n "$line" ]; then
            block+=$line$'\n'
            continue
        fi
        name=run-$(printf '%s' "$block" | sha256sum | cut -c 1-12)
        printf '%s' "$block" >"$folder/$name.set"
        printf '%s\n' "$name" >>"$folder/plan.new"
        block=
    done < <(combinations "" "$@")
    mv "$folder/plan.new" "$folder/plan"
}

# Does one run, unless it is done; always succeeds, the run's exit code goes to its .exit file.
one() {
    local scenario=$1 folder=$2 name=$3 line code=0
    local stem=$folder/$name arguments=() new=yes
    if [ -f "$stem.h5" ] && [ "$(cat "$stem.exit" 2>/dev/null)" = 0 ]; then
        return 0
    fi
    while IFS= read -r line; do arguments+=(--set "$line"); done <"$stem.set"
    rm -f "$stem.exit"
    if [ -f "$stem.h5.restart" ]; then
        $FBIMPACT run --resume "$stem.h5" --force --threads "$THREADS" >"$stem.log" 2>&1 || code=$?
        # What cannot be taken up, as on another kind of machine, is run anew.
        case $code in 4 | 6) code=0 ;; *) new=no ;; esac
    fi
    if [ "$new" = yes ]; then
        $FBIMPACT run "$scenario" -o "$stem.h5" --force --threads "$THREADS" "${arguments[@]}" >"$stem.log" 2>&1 || code=$?
    fi
    printf '%s\n' "$code" >"$stem.exit.new"
    mv "$stem.exit.new" "$stem.exit"
    [ "$code" = 0 ] || printf 'sweep.sh: %s failed with exit code %s, see %s.log\n' "$name" "$code" "$stem" >&2
}

# Writes the table; fails if a run of the plan is not complete.
collect() {
    local folder=$1 name failed=0
    $FBIMPACT collect "$folder" -o "$folder/table.csv"
    $FBIMPACT collect "$folder" -o "$folder/table.h5" -q
    while IFS= read -r name; do
        [ "$(cat "$folder/$name.exit" 2>/dev/null)" = 0 ] || failed=$((failed + 1))
    done <"$folder/plan"
    [ "$failed" = 0 ] || printf 'sweep.sh: %s of %s runs failed\n' "$failed" "$(wc -l <"$folder/plan")" >&2
    [ "$failed" = 0 ]
}

run_all() {
    local scenario=$1 folder=$2
    local runner=${RUNNER:-$(parallel --version 2>/dev/null | grep -q GNU && echo parallel || echo xargs)}
    export FBIMPACT THREADS
    case $runner in
    parallel) parallel --will-cite -j "$JOBS" "$0" --one "$scenario" "$folder" {} <"$folder/plan" ;;
    xargs) xargs -P "$JOBS" -I {} "$0" --one "$scenario" "$folder" {} <"$folder/plan" ;;
    *) fail "RUNNER is $runner, must be parallel or xargs" ;;
    esac
}

case ${1:-} in
--plan) shift && [ $# -ge 3 ] || fail "usage: --plan SCENARIO FOLDER KEY=VALUE…" && plan "$@" ;;
--one) shift && [ $# -eq 3 ] || fail "usage: --one SCENARIO FOLDER RUN" && one "$@" ;;
--collect) shift && [ $# -eq 1 ] || fail "usage: --collect FOLDER" && collect "$@" ;;
*)
    [ $# -ge 3 ] || fail "usage: sweep.sh SCENARIO.toml FOLDER 'KEY=VALUE VALUE…'…"
    plan "$@"
    run_all "$1" "$2"
    collect "$2"
    ;;
esac
