#!/usr/bin/env bash
# Compiles the fuzz targets with the compiler of the project; with SECONDS also runs each for so long, the bytes chosen by what they reach, from sound files.
#
#   scripts/check_fuzz.sh [SECONDS [PROGRAM]]      0: compile only (the default)
#
# Needs a compiler of C++ for the fuzzer; neither cargo-fuzz nor a nightly compiler, with which the sanitizer can be had (fuzz/README.md). What
# ends a target stays in target/fuzz/found.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-0} program=$(realpath "${2:-target/release/fbimpact}")
export CARGO_TARGET_DIR=$PWD/target/fuzz
[ -e fuzz/Cargo.lock ] || cp Cargo.lock fuzz/Cargo.lock # the versions of the program
if [ "$seconds" = 0 ]; then
    exec cargo check --manifest-path fuzz/Cargo.toml
fi

host=$(rustc -vV | sed -n 's/^host: //p')
counters="-Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
# With a target named these are not for what runs in the build.
RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module $counters -Cllvm-args=-sanitizer-coverage-trace-compares" \
    cargo build --release --target "$host" --manifest-path fuzz/Cargo.toml

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder"/{body_import,result_reading} target/fuzz/found
"$program" run -q --set simulation.end_time=2e-5 -o "$folder/result_reading/ball.h5" scenarios/sphere_on_plane.toml
"$program" export-body -q scenarios/sphere_on_plane.toml --body ball -o "$folder/body_import/ball.h5"
export RESULT=$folder/result_reading/ball.h5
for source in fuzz/fuzz_targets/*.rs; do
    target=$(basename "$source" .rs) sound=()
    case $target in
        scenario_text) sound=(scenarios) ;;
        mesh_reading) sound=(crates/fe-mesh/tests/gmsh crates/fe-mesh/tests/calculix) ;;
        matrix_reading) sound=(tests/matrix_parts) ;;
        spline_reading) sound=(crates/iga-core/tests/files) ;;
        body_import | result_reading) sound=(-max_len=600000) ;;
    esac
    mkdir -p "$folder/$target"
    echo "fuzz: $target for $seconds s"
    "target/fuzz/$host/release/$target" -max_total_time="$seconds" -timeout=60 -rss_limit_mb=4096 -artifact_prefix="target/fuzz/found/$target-" \
        "$folder/$target" "${sound[@]}" 2> "$folder/log" || { tail -40 "$folder/log"; exit 1; }
    tail -1 "$folder/log"
done
