#!/usr/bin/env bash
# Checks and runs a scenario with less memory than the machine has: under `ulimit -v`, and inside a control group where the machine lets
# one be made. Complete, or an exit code with a message that says what limits it; never a signal and never a panic.
#
# Usage: scripts/check_limits.sh PROGRAM
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/.."
scenario=$PWD/scenarios/sphere_on_plane.toml
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export FBIMPACT_CACHE=off

# outcome WHAT CODE: what a command that ended with CODE has to say.
outcome() {
    case $2 in
        0) echo "limits: $1: complete" ;;
        4 | 5 | 6)
            grep -Eq 'memory|threads cannot be started' "$folder/err" || { cat "$folder/err"; echo "limits: $1: no word of memory"; exit 1; }
            echo "limits: $1: $(head -c 100 "$folder/err" | head -1) …"
            ;;
        *) cat "$folder/err"; echo "limits: $1: ended with $2"; exit 1 ;;
    esac
}

# both WHAT COMMAND...: `check` and a short run of the program, started by COMMAND.
both() {
    local what=$1 code
    shift
    code=0; "$@" "$program" check "$scenario" 2> "$folder/err" || code=$?
    outcome "$what, check" "$code"
    code=0; "$@" "$program" run -q --threads 2 --force -o "$folder/out.h5" --set simulation.end_time=1e-3 "$scenario" 2> "$folder/err" || code=$?
    outcome "$what, run" "$code"
}

within_addresses() { (ulimit -v "$1"; shift; exec "$@"); }
for mebibytes in 100 200 400 1000 2000; do
    both "$mebibytes MiB of addresses" within_addresses "$((mebibytes << 10))"
done

# Whoever may make control groups of either version makes some of 12 MB to 1 GB; else systemd is asked for one.
within_group() { (echo "$BASHPID" > "$1/cgroup.procs"; shift; exec "$@"); }
group=
for parent in /sys/fs/cgroup/memory /sys/fs/cgroup; do
    limit=memory.max; [ -e "$parent/memory.limit_in_bytes" ] && limit=memory.limit_in_bytes
    if mkdir "$parent/fbimpact-$$" 2> /dev/null; then
        if { echo 1000000000 > "$parent/fbimpact-$$/$limit"; } 2> /dev/null; then
            group=$parent/fbimpact-$$
            trap 'rm -rf "$folder"; rmdir "$group" || true' EXIT
            break
        fi
        rmdir "$parent/fbimpact-$$"
    fi
done
if [ -n "$group" ]; then
    for megabytes in 12 60 120 250 1000; do
        echo "${megabytes}000000" > "$group/$limit"
        both "control group of $megabytes MB" within_group "$group"
    done
elif systemd-run --user --scope -q -p MemoryMax=1G true 2> /dev/null; then
    both "scope of 1 GB" systemd-run --user --scope -q -p MemoryMax=1G
else
    echo "limits: no control group can be made here, that part is skipped"
fi
