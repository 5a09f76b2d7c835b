#!/usr/bin/env bash
# Runs every example of the two papers and writes docs/reproduction.md with figures in docs/reproduction/: computed values beside the
# printed ones, forces, energies, velocities, trials and times.
#
#   scripts/reproduce_paper.sh [--long] [FOLDER]      (FOLDER: results, default target/reproduction; complete ones are kept)
#
# Without --long what takes many minutes (damped models, the printed search in three dimensions, the study of resolution)
# is left out, and the page says so. Environment: FBIMPACT  the program (default: cargo run --release).
# Needs python3 beside the program.
set -euo pipefail
cd "$(dirname "$0")/.."
exec python3 scripts/reproduce_paper.py "$@"
