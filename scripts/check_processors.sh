#!/usr/bin/env bash
# The same result to the last bit on this processor and on an emulated one that has AVX2 and no wider vectors.
# Usage: scripts/check_processors.sh [PROGRAM]; needs qemu-user (Debian's package of that name), which is installed if it may be.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${1:-target/release/fbimpact}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

if ! command -v qemu-x86_64 > /dev/null; then
    { apt-get update && apt-get install --yes --no-install-recommends qemu-user; } > "$folder/apt.log" 2>&1 || {
        cat "$folder/apt.log"
        echo "error: qemu-x86_64 is missing, install the package qemu-user" >&2
        exit 1
    }
fi

# An emulated second is some four hundred times as long: a small model, and the first part of its impact.
arguments=(run scenarios/sphere_on_plane.toml --quiet --set simulation.end_time=1e-5 --set bodies.ball.discretisation.elements=4
    --set 'bodies.ball.discretisation.refine=[{ marker = "bottom", width = 0.24e-3, elements = 8 }]')
"$program" "${arguments[@]}" -o "$folder/native.h5"
qemu-x86_64 -cpu Haswell "$program" "${arguments[@]}" -o "$folder/avx2.h5" 2> "$folder/emulator.log" || {
    cat "$folder/emulator.log"
    exit 1
}
"$program" compare "$folder/avx2.h5" "$folder/native.h5" --rtol 0 --atol 0 | tail -n 1
