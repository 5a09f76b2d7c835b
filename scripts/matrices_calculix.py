#!/usr/bin/env python3
"""Writes stiffness and mass of a small bar as CalculiX stores them, for tests/import_body.rs. Needs `ccx`.

Four bricks of 40 mm × 10 mm × 10 mm whose inner sections are skew: nodes lie on the edges of the bar, so that it stays a box. Numbers of
nodes have gaps and do not rise along the bar. Units: N, mm, tonne, s.

Usage: scripts/matrices_calculix.py tests/matrix_parts
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

# Places of the sections along the bar at its four edges.
SECTIONS = [[0, 0, 0, 0], [9, 11, 12, 10], [21, 19, 20, 22], [30, 31, 28, 29], [40, 40, 40, 40]]
CORNERS = [(-5, -5), (5, -5), (5, 5), (-5, 5)]


def label(section, corner):
    return 100 - 20 * section + 3 * corner + 1


def model():
    lines = ["*NODE, NSET=ALL"]
    for s, places in enumerate(SECTIONS):
        for c, (y, z) in enumerate(CORNERS):
            lines.append(f"{label(s, c)}, {places[c]}., {y}., {z}.")
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=PART")
    for e in range(len(SECTIONS) - 1):
        nodes = [label(e, c) for c in range(4)] + [label(e + 1, c) for c in range(4)]
        lines.append(", ".join(map(str, [e + 1, *nodes])))
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210000., 0.3", "*DENSITY", "7.85e-9"]
    lines += ["*SOLID SECTION, ELSET=PART, MATERIAL=STEEL"]
    lines += ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "12", "*END STEP"]
    return "\n".join(lines) + "\n"


def main():
    target = pathlib.Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "bar.inp").write_text(model())
        subprocess.run(["ccx", "bar"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        for ending in ("inp", "sti", "mas", "dof"):
            shutil.copy(folder / f"bar.{ending}", target / f"bar.{ending}")


if __name__ == "__main__":
    main()
