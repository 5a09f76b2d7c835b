#!/usr/bin/env bash
# Writes the reference traces of the short scenarios: small results that `fbimpact compare` takes as its second argument.
#
#   scripts/make_references.sh [SCENARIO…]      (names without .toml; default: all that have a trace)
#
# Environment: FBIMPACT  the program (default: cargo run --release).
# The files are never written anew in the change that moves the physics: see docs/compare.md.
set -euo pipefail
cd "$(dirname "$0")/.."
traces=tests/reference/traces
read -ra fbimpact <<<"${FBIMPACT:-cargo run --locked --release --quiet --}"

if [ $# -eq 0 ]; then
    for trace in "$traces"/*.h5; do set -- "$@" "$(basename "$trace" .h5)"; done
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for name in "$@"; do
    # What a trace needs to be the same on all machines stands as KEY=VALUE lines in a .set file.
    sets=()
    if [ -f "$traces/$name.set" ]; then
        while IFS= read -r line; do sets+=(--set "$line"); done <"$traces/$name.set"
    fi
    "${fbimpact[@]}" run "scenarios/$name.toml" -q -o "$scratch/$name.h5" "${sets[@]}"
    "${fbimpact[@]}" thin "$scratch/$name.h5" -o "$traces/$name.h5" --force
done
