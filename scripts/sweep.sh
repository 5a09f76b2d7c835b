#!/usr/bin/env bash
# Runs a scenario with all combinations of values, several at a time, and gathers the results in one table.
#
#   scripts/sweep.sh SCENARIO.toml FOLDER 'KEY=VALUE VALUE…' ['KEY=VALUE VALUE…']…
#
#   scripts/sweep.sh scenarios/sphere_on_plane.toml sweep \
#       'bodies.ball.velocity=[0,0,-0.05] [0,0,-0.1]' 'materials.aluminium.youngs_modulus=70e9..75e9/6'
#
# Values are separated by spaces and contain none. A..B/N stands for N values from A to B at equal distances, [0,0,A]..[0,0,B]/N for N vectors. KEY&KEY=VALUE&VALUE VALUE&VALUE… pairs
# values of several keys. Options of `fbimpact collect` for the table, such as --column, may be given in COLLECT. Every run leaves in FOLDER, under a name made from its values,
#   <run>.set   its KEY=VALUE lines      <run>.exit   its exit code
#   <run>.h5    its result               <run>.log    what it said
# and the table is FOLDER/table.csv and FOLDER/table.h5. Called again, it does what is missing: complete runs are skipped, killed ones
# go on, failed ones are tried again, added values are added. One failed run stops no other; the exit code is then 1.
#
# Environment: FBIMPACT  the program (default: fbimpact)       JOBS     runs at a time (default: number of cores)
#              THREADS   threads of a run (default: 1)         RUNNER   parallel or xargs (default: GNU parallel if there)
#              COLLECT   further arguments of `fbimpact collect`, as a shell has them: "--column 'v=bodies.ball.velocity[-1].z'"
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
    local key=${1%%=*} values value keys parts lines i
    mapfile -t values < <(expanded "${1#*=}")
    IFS='&' read -ra keys <<<"$key"
    shift
    for value in "${values[@]}"; do
        lines=$key=$value$'\n'
        if [ "${#keys[@]}" -gt 1 ]; then
            IFS='&' read -ra parts <<<"$value"
            lines=
            for i in "${!keys[@]}"; do lines+=${keys[i]}=${parts[i]}$'\n'; done
        fi
        combinations "$prefix$lines" "$@"
    done
}

# Prints values, one a line, A..B/N as N values, [A,A,…]..[B,B,…]/N as N vectors.
expanded() {
    local number='[-+]?[0-9]*\.?[0-9]+([eE][-+]?[0-9]+)?' values value
    local vector="\[($number)(,$number)*\]"
    read -ra values <<<"$1"
    for value in "${values[@]}"; do
        if [[ $value =~ ^($number)\.\.($number)/([0-9]+)$ || $value =~ ^$vector\.\.$vector/([0-9]+)$ ]]; then
            LC_ALL=C awk -v range="$value" 'BEGIN {
                split(range, parts, "[.][.]"); split(parts[2], end, "/"); n = end[2]; is_vector = parts[1] ~ /^\[/
                gsub(/[][]/, "", parts[1]); gsub(/[][]/, "", end[1])
                size = split(parts[1], a, ","); if (split(end[1], b, ",") != size) exit 1
                for (i = 0; i < n; i++) {
                    line = ""
                    for (k = 1; k <= size; k++) line = line (k > 1 ? "," : "") sprintf("%.12g", n > 1 ? a[k] + (b[k] - a[k]) * i / (n - 1) : a[k])
                    print is_vector ? "[" line "]" : line
                }
            }'
        else
            printf '%s\n' "$value"
        fi
    done
}

# Whether two vectors have as many numbers.
same_size() {
    local first=${1//[^,]/} second=${2//[^,]/}
    [ "${#first}" = "${#second}" ]
}

# Fails for values that are no pairs where keys are, for keys given twice, and for a range without values.
check() {
    local spec key value values keys parts known=' '
    for spec in "$@"; do
        [[ $spec == ?*=* && -n ${spec#*=} ]] || fail "'$spec' is not KEY=VALUE VALUE…"
        IFS='&' read -ra keys <<<"${spec%%=*}"
        for key in "${keys[@]}"; do
            [ -n "$key" ] || fail "'$spec' has an empty key"
            [[ $known != *" $key "* ]] || fail "'$key' is given twice"
            known+="$key "
        done
        read -ra values <<<"${spec#*=}"
        for value in "${values[@]}"; do
            [[ $value != \[*]..\[*]/* ]] || same_size "${value%%..*}" "${value##*..}" || fail "'$value': both ends of a range have as many numbers"
        done
        mapfile -t values < <(expanded "${spec#*=}")
        [ "${#values[@]}" -gt 0 ] || fail "'$spec' has no values"
        [ "${#keys[@]}" -gt 1 ] || continue
        for value in "${values[@]}"; do
            IFS='&' read -ra parts <<<"$value"
            [ "${#parts[@]}" -eq "${#keys[@]}" ] || fail "'$value' has ${#parts[@]} values, the keys ${spec%%=*} are ${#keys[@]}"
        done
    done
}

# Writes FOLDER/plan and a .set file for each run.
plan() {
    local scenario=$1 folder=$2 sum block name
    shift 2
    [ -f "$scenario" ] || fail "$scenario: no such scenario"
    check "$@"
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
    local scenario=$1 folder=$2 name=$3 line code=0 begun=$SECONDS
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
    if [ "$code" = 0 ]; then
        line="complete in $((SECONDS - begun)) s"
    else
        line="failed with exit code $code, see $stem.log"
    fi
    printf 'sweep.sh: %s%s %s%s\n' "$(place "$folder")" "$name" "$line" "$(left "$folder")" >&2
}

# Number of runs of the plan that have ended.
ended() {
    local folder=$1 name n=0
    while IFS= read -r name; do
        [ ! -f "$folder/$name.exit" ] || n=$((n + 1))
    done <"$folder/plan"
    printf '%s' "$n"
}

# "3 of 12: " in a sweep on this machine; nothing in others, whose runs do not know of each other.
place() {
    [ ! -f "$1/begun" ] || printf '%s of %s: ' "$(ended "$1")" "$(wc -l <"$1/plan")"
}

# ", about 40 s left", from the time that the runs since the start of the sweep took.
left() {
    local folder=$1 start before now total
    [ -f "$folder/begun" ] || return 0
    read -r start before <"$folder/begun"
    now=$(ended "$folder") total=$(wc -l <"$folder/plan")
    [ "$now" -gt "$before" ] && [ "$total" -gt "$now" ] || return 0
    printf ', about %s s left' "$((($(date +%s) - start) * (total - now) / (now - before)))"
}

# Writes the table; fails if a run of the plan is not complete.
collect() {
    local folder=$1 name failed=0
    local more=()
    eval "more=(${COLLECT:-})"
    $FBIMPACT collect "$folder" -o "$folder/table.csv" "${more[@]}"
    $FBIMPACT collect "$folder" -o "$folder/table.h5" -q "${more[@]}"
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
    printf '%s %s\n' "$(date +%s)" "$(ended "$folder")" >"$folder/begun"
    case $runner in
    parallel) parallel --will-cite -j "$JOBS" "$0" --one "$scenario" "$folder" {} <"$folder/plan" ;;
    xargs) xargs -P "$JOBS" -I {} "$0" --one "$scenario" "$folder" {} <"$folder/plan" ;;
    *) fail "RUNNER is $runner, must be parallel or xargs" ;;
    esac
    rm -f "$folder/begun"
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
