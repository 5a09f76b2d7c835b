#!/usr/bin/env bash
# Compiles the fuzz targets with the compiler of the project; where cargo-fuzz and a nightly compiler are installed, runs each for a while.
#
#   scripts/check_fuzz.sh [SECONDS]      0: compile only (the default)
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-0}
CARGO_TARGET_DIR=$PWD/target/fuzz cargo check --manifest-path fuzz/Cargo.toml
[ "$seconds" -gt 0 ] || exit 0
if ! cargo +nightly fuzz --version >/dev/null 2>&1; then
    echo "fuzz: cargo-fuzz or a nightly compiler is not installed, targets are compiled and not run"
    exit 0
fi
cargo +nightly fuzz list | while IFS= read -r target; do
    cargo +nightly fuzz run -s none "$target" -- -max_total_time="$seconds"
done
