#!/usr/bin/env python3
"""Make the references that CalculiX gives for finite element meshes (docs/verification.md).

Usage: mesh_calculix.py [FOLDER]; needs ccx on the path. Without it only the input files are written.

Writes to crates/fe-mesh/tests/calculix, for one distorted element with curved sides of each type, its input file and `TYPE.ref`: the
entries of stiffness and mass, "k row column value" and "m row column value" with rows 3 node + direction from 0, mass of the first direction only; and to
tests/mesh_parts a bent, tapered bar of tetrahedra and of hexahedra with its first frequencies [Hz] and with the stress [Pa] at some of its
nodes, "node xx yy zz xy yz zx", where one end is held in every node and the other carries a uniform traction. Stress at nodes is what the
integration points show, continued linearly to the nodes of each element by least squares and averaged over the elements of a node.
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
# The force on the tip of the bar [N].
FORCE = (-300.0, 200.0, 500.0)
# Sides of elements, corners and then middles; rules on them, exact for the area times a function of flat sides.
SIDES = {
    "C3D10": [(0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6)],
    "C3D20": [(0, 3, 2, 1, 11, 10, 9, 8), (4, 5, 6, 7, 12, 13, 14, 15), (0, 1, 5, 4, 8, 17, 12, 16),
              (1, 2, 6, 5, 9, 18, 13, 17), (2, 3, 7, 6, 10, 19, 14, 18), (3, 0, 4, 7, 11, 16, 15, 19)],
}
G3 = math.sqrt(0.6)
LINE = [(-G3, 5 / 9), (0.0, 8 / 9), (G3, 5 / 9)]
RULES = {
    6: [((0.5, 0.0), 1 / 6), ((0.5, 0.5), 1 / 6), ((0.0, 0.5), 1 / 6)],
    8: [((r, s), v * w) for r, v in LINE for s, w in LINE],
}
# Integration points of CalculiX (gauss.f: gauss3d3, gauss3d5), in its order, and parameters of the nodes.
T4 = [0.138196601125011, 0.585410196624968]
POINTS = {
    "C3D10": [[T4[1] if d == g - 1 else T4[0] for d in range(3)] for g in range(4)],
    "C3D20": [[r[0], s[0], t[0]] for t in LINE for s in LINE for r in LINE],
}


def with_middles(corners, edges):
    return corners + [[0.5 * (corners[a][d] + corners[b][d]) for d in range(3)] for a, b in edges]


PARAMETERS = {
    "C3D10": with_middles([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], TET_EDGES),
    "C3D20": with_middles([[2 * c - 1 for c in corner] for corner in CUBE], HEX_EDGES),
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


def tip_forces(nodes, elements, kind, members):
    """Force on each node of the flat face `members` of a uniform traction with the sum `FORCE`: its share of the area."""
    face = set(members)
    share = dict.fromkeys(members, 0.0)
    for element in elements:
        for side in SIDES[kind]:
            on = [element[i] for i in side]
            if not face.issuperset(on):
                continue
            x = [nodes[n] for n in on]
            for (r, s), weight in RULES[len(on)]:
                values, slopes = side_functions(len(on), r, s)
                du, dv = ([sum(g[k] * p[d] for g, p in zip(slopes, x)) for d in range(3)] for k in range(2))
                area = math.hypot(*(du[i - 2] * dv[i - 1] - du[i - 1] * dv[i - 2] for i in range(3)))
                for n, value in zip(on, values):
                    share[n] += weight * area * value
    total = sum(share.values())
    return {n: [f * a / total for f in FORCE] for n, a in share.items()}


def side_functions(n, r, s):
    """Functions of a side of six or eight nodes and their slopes along r and s, by differences (they are polynomials of second order)."""
    def values(r, s):
        if n == 6:
            t = 1 - r - s
            return [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        return [0.25 * (1 + a * r) * (1 + b * s) * (a * r + b * s - 1) for a, b in corners] + [
            0.5 * (1 - r * r) * (1 - s), 0.5 * (1 + r) * (1 - s * s), 0.5 * (1 - r * r) * (1 + s), 0.5 * (1 - r) * (1 - s * s)]
    h = 1e-4
    ahead, behind = (values(r + h, s), values(r, s + h)), (values(r - h, s), values(r, s - h))
    slopes = [[(ahead[k][i] - behind[k][i]) / (2 * h) for k in range(2)] for i in range(n)]
    return values(r, s), slopes


def stresses(kind, cells):
    """Stress at some nodes of the bar, held at its root and pulled at its tip."""
    nodes, elements = mesh(kind, cells, bar)
    root = [i for i, p in enumerate(nodes) if abs(p[1]) < 1e-9]
    tip = [i for i, p in enumerate(nodes) if abs(p[0]) < 1e-9]
    loads = "".join(
        f"{n + 1}, {d + 1}, {force[d]:.12e}\n" for n, force in tip_forces(nodes, elements, kind, tip).items() for d in range(3)
    )
    step = f"*STATIC\n*BOUNDARY\nROOT, 1, 3\n*CLOAD\n{loads}*EL PRINT, ELSET=PART\nS"
    data = run(card(kind, nodes, elements, [("ROOT", root)]), step)[".dat"]
    rows = [line.split() for line in data.splitlines()]
    rows = [row for row in rows if len(row) == 8 and row[0].isdigit()]
    at_points = {(int(row[0]), int(row[1])): [float(x) for x in row[2:]] for row in rows}
    points, corners = POINTS[kind], PARAMETERS[kind]
    assert len(rows) == len(points) * len(elements)
    sums = {}
    for e, element in enumerate(elements, 1):
        values = [at_points[e, g + 1] for g in range(len(points))]
        for node, weights in zip(element, continuation(points, corners)):
            own = [sum(w * value[c] for w, value in zip(weights, values)) for c in range(6)]
            sums.setdefault(node, []).append(own)
    # Of the nodes off the held end, where stress is singular, every ninth.
    free = [n for n in sorted(sums) if math.atan2(nodes[n][1], nodes[n][0]) > math.pi / 8][::9]
    mean = {n: [sum(s[c] for s in sums[n]) / len(sums[n]) for c in range(6)] for n in free}
    # CalculiX prints xx, yy, zz, xy, xz, yz.
    lines = [f"{n + 1} " + " ".join(f"{s[c]:.8e}" for c in (0, 1, 2, 3, 5, 4)) for n, s in mean.items()]
    return "\n".join(lines) + "\n"


def continuation(points, corners):
    """For each place of `corners` the weights of the values at `points`: linear, by least squares; `points` lie evenly about their middle."""
    n = len(points)
    middle = [sum(p[d] for p in points) / n for d in range(3)]
    arms = [[p[d] - middle[d] for d in range(3)] for p in points]
    # Off-diagonal moments: none of the cube; of the tetrahedron the same for all pairs.
    a = sum(arm[0] * arm[0] for arm in arms)
    b = sum(arm[0] * arm[1] for arm in arms)
    # Inverse of (a - b) I + b (all ones).
    diagonal, shared = 1 / (a - b), -b / ((a - b) * (a + 2 * b))
    weights = []
    for place in corners:
        x = [place[d] - middle[d] for d in range(3)]
        slope = [diagonal * x[d] + shared * sum(x) for d in range(3)]
        weights.append([1 / n + sum(g * arm for g, arm in zip(slope, arms_p)) for arms_p in arms])
    return weights


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
        if shutil.which("ccx"):
            write(root / "tests/mesh_parts", name, text, "stress", stresses(kind, cells))


if __name__ == "__main__":
    main()
