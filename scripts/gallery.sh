#!/bin/sh
# Draws the figures of docs/gallery.md again. FBIMPACT names the program (default: fbimpact).
set -eu
cd "$(dirname "$0")/.."
program=${FBIMPACT:-fbimpact}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
draw() { # scenario, kinds of figures, more arguments of run
    name=$1 kinds=$2
    shift 2
    "$program" run -q "scenarios/$name.toml" -o "$work/$name.h5" "$@"
    for kind in $kinds; do
        "$program" plot -q "$work/$name.h5" -o "$work/figures" --figure "$kind"
    done
}
draw rigid_double_pendulums "energies impacts points" --set simulation.end_time=0.2
draw sphere_rod_sphere "impacts points tries"
draw oblique_discs "forces energies"
rm "$work/figures/rigid_double_pendulums_point_right_tip.svg"
cp "$work"/figures/*.svg docs/gallery/
