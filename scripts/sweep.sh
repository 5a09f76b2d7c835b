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
# and the table is FOLDER/table.csv and FOLDER/table.h5. Called again, it does what is missing: runs that are complete are skipped unless
# the scenario, a file that it names or the program has changed; killed ones go on, failed ones are tried again, added values are added.
# One failed run stops no other; the exit code is then 1. Names may hold any character.
#
# Environment: FBIMPACT  the program (default: fbimpact)       JOBS     runs at a time (default: number of cores)
#              THREADS   threads of a run (default: 1)
#              COLLECT   further arguments of `fbimpact collect`, quoted as in a shell: "--column 'v=bodies.ball.velocity[-1].z'"
#
# For schedulers: `--plan SCENARIO FOLDER KEY=…` only writes the .set files and FOLDER/plan, one run a line; `--todo SCENARIO FOLDER`
# prints the runs of the plan that are not done; `--one SCENARIO FOLDER RUN` does one run; `--collect FOLDER` writes the table.
set -euo pipefail

FBIMPACT=${FBIMPACT:-fbimpact}
THREADS=${THREADS:-1}
JOBS=${JOBS:-$(nproc 2>/dev/null || echo 1)}

say() {
    printf 'sweep.sh: %s\n' "$1" >&2
}

fail() {
    say "$1"
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
    local scenario=$1 folder=$2 path block name
    shift 2
    [ -f "$scenario" ] || fail "$(printf '%q: no such scenario' "$scenario")"
    check "$@"
    mkdir -p -- "$folder"
    # Files of another scenario, or of no sweep, are not replaced.
    if [ -e "$folder/plan" ] && [ ! -e "$folder/scenario.path" ] && [ ! -e "$folder/scenario.sha256" ]; then
        fail "$(printf '%q is of no sweep, use another folder' "$folder/plan")"
    fi
    path=$(realpath -- "$scenario")
    if [ -e "$folder/scenario.path" ] && [ "$(cat -- "$folder/scenario.path")" != "$path" ]; then
        fail "$(printf '%q was begun with %q, use another folder' "$folder" "$(cat -- "$folder/scenario.path")")"
    fi
    printf '%s\n' "$path" >"$folder/scenario.path"
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
    local stem=$folder/$name
    if is_done "$scenario" "$folder" "$name"; then
        return 0
    fi
    rm -f -- "$stem.exit"
    update "$scenario" "$stem" --threads "$THREADS" >"$stem.log" 2>&1 || code=$?
    printf '%s\n' "$code" >"$stem.exit.new"
    mv -- "$stem.exit.new" "$stem.exit"
    if [ "$code" = 0 ]; then
        line="complete in $((SECONDS - begun)) s"
    else
        line=$(printf 'failed with exit code %s, see %q' "$code" "$stem.log")
    fi
    say "$(place "$folder")$name $line$(left "$folder")"
}

# Brings the result $2.h5 up to date: complete ones stay, killed runs go on, all else is run anew.
update() {
    local scenario=$1 stem=$2 line arguments=()
    shift 2
    while IFS= read -r line; do arguments+=(--set "$line"); done <"$stem.set"
    "$FBIMPACT" run --update --force -o "$stem.h5" "$@" "${arguments[@]}" -- "$scenario"
}

# Whether a run is complete, of the scenario, the files that it names and the program as they are now.
is_done() {
    [ "$(cat -- "$2/$3.exit" 2>/dev/null)" = 0 ] && update "$1" "$2/$3" --dry-run >/dev/null 2>&1
}

# Prints the runs of the plan that are not done.
todo() {
    local name
    while IFS= read -r name; do
        is_done "$1" "$2" "$name" </dev/null || printf '%s\n' "$name"
    done <"$2/plan"
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
    local folder=$1 name words failed=0 more=()
    # Words as a shell has them, of which nothing is executed.
    words=$(printf '%s' "${COLLECT:-}" | xargs printf '%s\n') || fail "COLLECT: $COLLECT: a quote is not closed"
    [ -z "$words" ] || mapfile -t more <<<"$words"
    "$FBIMPACT" collect -o "$folder/table.csv" "${more[@]}" -- "$folder"
    "$FBIMPACT" collect -o "$folder/table.h5" -q "${more[@]}" -- "$folder"
    while IFS= read -r name; do
        [ "$(cat "$folder/$name.exit" 2>/dev/null)" = 0 ] || failed=$((failed + 1))
    done <"$folder/plan"
    [ "$failed" = 0 ] || say "$failed of $(wc -l <"$folder/plan") runs failed"
    [ "$failed" = 0 ]
}

run_all() {
    local scenario=$1 folder=$2
    export FBIMPACT THREADS
    printf '%s %s\n' "$(date +%s)" "$(ended "$folder")" >"$folder/begun"
    # Names stand before the run, where xargs looks for nothing to replace.
    xargs -P "$JOBS" -n 1 bash "$0" --one "$scenario" "$folder" <"$folder/plan"
    rm -f -- "$folder/begun"
}

task=all
case ${1:-} in
--plan | --todo | --one | --collect) task=${1#--} && shift ;;
esac
case $task:$# in
all:[012] | plan:[012]) fail "usage: sweep.sh [--plan] SCENARIO.toml FOLDER 'KEY=VALUE VALUE…'…" ;;
all:* | plan:* | todo:2 | one:3 | collect:1) ;;
*) fail "usage: sweep.sh --todo SCENARIO FOLDER, --one SCENARIO FOLDER RUN or --collect FOLDER" ;;
esac
# No name may look like an option.
names=()
for name in "${@:1:2}"; do
    case $name in -*) name=./$name ;; esac
    names+=("$name")
done
case $task in
all)
    plan "${names[@]}" "${@:3}"
    run_all "${names[@]}"
    collect "${names[1]}"
    ;;
*) "$task" "${names[@]}" "${@:3}" ;;
esac
