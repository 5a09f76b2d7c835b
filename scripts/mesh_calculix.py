#!/usr/bin/env python3
"""Make the references that CalculiX gives for finite element meshes (docs/verification.md).

Usage: mesh_calculix.py [FOLDER]; needs ccx on the path. Without it only the input files are written.

Writes to crates/fe-mesh/tests/calculix, for one distorted element with curved sides of each type, its input file and `TYPE.ref`: the
entries of stiffness and mass, "k row column value" and "m row column value" with rows 3 node + direction from 0, mass of the first direction only; and to
tests/mesh_parts a bent, tapered bar of tetrahedra and of hexahedra with its first frequencies [Hz].
"""

import itertools
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
YOUNG, POISSON, DENSITY = 210e9, 0.3, 7850.0
MODES = 26  # six rigid motions and twenty more

CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
TET_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
TETRAHEDRA = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
# type: pieces of a cube, edges with nodes in their middles
TYPES = {
    "C3D8": ([tuple(range(8))], []),
    "C3D10": (TETRAHEDRA, TET_EDGES),
    "C3D15": ([(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)], WEDGE_EDGES),
    "C3D20": ([tuple(range(8))], HEX_EDGES),
}


def mesh(kind, cells, place, only_first=False):
    """Positions of the nodes and nodes of the elements, both from 0."""
    pieces, edges = TYPES[kind]
    numbers, nodes, elements = {}, [], []
    for cell in itertools.product(*(range(n) for n in reversed(cells))):
        cell = cell[::-1]
        for piece in pieces[:1] if only_first else pieces:
            corners = [tuple(2 * (cell[d] + CUBE[c][d]) for d in range(3)) for c in piece]
            lattice = corners + [tuple((corners[a][d] + corners[b][d]) // 2 for d in range(3)) for a, b in edges]
            for point in lattice:
                if point not in numbers:
                    numbers[point] = len(nodes)
                    nodes.append(place(*(point[d] / (2 * cells[d]) for d in range(3))))
            elements.append([numbers[point] for point in lattice])
    return nodes, elements


def card(kind, nodes, elements, sets=()):
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i + 1}, " + ", ".join(f"{x:.12e}" for x in p) for i, p in enumerate(nodes)]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=PART")
    for i, e in enumerate(elements):
        fields = [str(i + 1)] + [str(n + 1) for n in e]
        rows = [", ".join(fields[k:k + 11]) for k in range(0, len(fields), 11)]
        lines.append(",\n".join(rows))
    for name, members in sets:
        lines.append(f"*NSET, NSET={name}")
        lines += [", ".join(str(n + 1) for n in members[k:k + 10]) for k in range(0, len(members), 10)]
    return "\n".join(lines) + "\n"


def analysis(step):
    return (
        f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{YOUNG:.6e}, {POISSON}\n*DENSITY\n{DENSITY}\n"
        f"*SOLID SECTION, ELSET=PART, MATERIAL=STEEL\n*STEP\n{step}\n*END STEP\n"
    )


def run(text, step):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "job"
        path.with_suffix(".inp").write_text(text + analysis(step))
        subprocess.run(["ccx", "job"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        return {p.suffix: p.read_text() for p in pathlib.Path(folder).glob("job.*") if p.suffix != ".12d"}


def distorted(x, y, z):
    return (x + 0.12 * y * y - 0.05 * z * x, y + 0.1 * z * (1.2 - x), z * (1 + 0.15 * x) + 0.07 * math.sin(2 * y))


def bar(x, y, z):
    """A quarter of a ring, radius 50 to 70 mm, that gets thinner along its arc [m]."""
    angle, radius = 0.5 * math.pi * x, 0.07 - 0.02 * y
    return radius * math.cos(angle), radius * math.sin(angle), 0.012 * (1 - 0.4 * x) * z


def matrices(kind):
    nodes, elements = mesh(kind, (1, 1, 1), distorted, only_first=True)
    text = card(kind, nodes, elements)
    out = [text, None]
    if shutil.which("ccx"):
        files = run(text, "*FREQUENCY, SOLVER=MATRIXSTORAGE\n")
        dofs = [tuple(int(n) for n in line.split(".")) for line in files[".dof"].split()]
        rows = [3 * (node - 1) + direction - 1 for node, direction in dofs]
        lines = []
        for letter, suffix in (("k", ".sti"), ("m", ".mas")):
            for line in files[suffix].splitlines():
                i, j, value = line.split()
                i, j = rows[int(i) - 1], rows[int(j) - 1]
                if letter == "m" and (i % 3 or j % 3):
                    continue
                lines.append(f"{letter} {max(i, j)} {min(i, j)} {float(value):.13e}")
        out[1] = "\n".join(lines) + "\n"
    return out


def frequencies(kind, cells):
    nodes, elements = mesh(kind, cells, bar)
    ends = [("ROOT", [i for i, p in enumerate(nodes) if abs(p[1]) < 1e-9]),
            ("TIP", [i for i, p in enumerate(nodes) if abs(p[0]) < 1e-9])]
    text = card(kind, nodes, elements, ends)
    if not shutil.which("ccx"):
        return text, None
    data = run(text, f"*FREQUENCY\n{MODES}\n")[".dat"]
    rows = [line.split() for line in data.splitlines()]
    values = [float(row[1]) for row in rows if len(row) == 5 and row[0].isdigit()][:MODES]
    return text, "\n".join(f"{math.sqrt(v) / (2 * math.pi):.9e}" for v in values[6:]) + "\n"


def write(folder, name, text, suffix, reference):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.inp").write_text(text)
    if reference:
        (folder / f"{name}.{suffix}").write_text(reference)


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    for kind in TYPES:
        text, reference = matrices(kind)
        write(root / "crates/fe-mesh/tests/calculix", kind.lower(), text, "ref", reference)
    for name, kind, cells in (("bar_hex20", "C3D20", (6, 2, 1)), ("bar_tet10", "C3D10", (6, 2, 1))):
        text, reference = frequencies(kind, cells)
        write(root / "tests/mesh_parts", name, text, "frequencies", reference)


if __name__ == "__main__":
    main()
