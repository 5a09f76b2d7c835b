#!/usr/bin/env python3
"""Write a CalculiX model of a solid beam whose end faces are held on the mean (docs/verification.md).

Usage: solid_beam_calculix.py SUPPORT NX NY NZ [ELEMENT] > beam.inp, then `ccx beam`; frequencies stand in beam.dat.

SUPPORT is clamp (six mean conditions of the face x = 0), hinge (all but the mean rotation about y), hinges (both ends),
held (every point of the face) or held-hinge (the face turns about y as a rigid one). Elimination gives every condition
an unknown of its own, as *EQUATION asks.
"""

import itertools
import sys

SIZE = (0.3, 0.03, 0.01)  # m
YOUNG, POISSON, DENSITY = 70e9, 0.33, 2700.0
GAUSS = [(-(0.6**0.5), 5 / 9), (0.0, 8 / 9), (0.6**0.5, 5 / 9)]
# Nodes of C3D20 in the order of CalculiX, on a grid of half elements.
BRICK = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
         (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
         (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]


def serendipity(s, t, a, b):
    """Function of the node (a, b), each -1, 0 or 1, of a quadrilateral with eight nodes."""
    if a and b:
        return 0.25 * (1 + s * a) * (1 + t * b) * (s * a + t * b - 1)
    return 0.5 * (1 - s * s) * (1 + t * b) if b else 0.5 * (1 + s * a) * (1 - t * t)


def mean_conditions(elements, x, component_numbers):
    """Coefficients {(node, direction): c} of the mean displacements of the end at x and of their mean moments."""
    h = [SIZE[d] / elements[d] for d in (1, 2)]
    rows = [{} for _ in range(6)]
    for j, k in itertools.product(range(elements[1]), range(elements[2])):
        for (s, v), (t, w) in itertools.product(GAUSS, GAUSS):
            y = h[0] * (j + 0.5 + 0.5 * s) - 0.5 * SIZE[1]
            z = h[1] * (k + 0.5 + 0.5 * t) - 0.5 * SIZE[2]
            for a, b in itertools.product((-1, 0, 1), (-1, 0, 1)):
                if not (a or b):
                    continue
                node = (x, 2 * j + 1 + a, 2 * k + 1 + b)
                share = serendipity(s, t, a, b) * v * w / (4 * elements[1] * elements[2])
                # u_x, u_y, u_z; y u_z - z u_y, z u_x, -y u_x.
                terms = (0, 1, 1), (1, 2, 1), (2, 3, 1), (3, 3, y), (3, 2, -z), (4, 1, z), (5, 1, -y)
                for row, direction, factor in terms:
                    rows[row][node, direction] = rows[row].get((node, direction), 0.0) + factor * share
    return [rows[i] for i in component_numbers]


def reduced(rows):
    """The same conditions, each with an unknown of its own, by elimination with full pivoting."""
    rows, own = [dict(row) for row in rows], []
    for i, row in enumerate(rows):
        pivot = max(row, key=lambda key: abs(row[key]))
        rows[i] = row = {key: c / row[pivot] for key, c in row.items()}
        for other in rows[:i] + rows[i + 1:]:
            factor = other.pop(pivot, 0.0)
            for key, c in row.items():
                if factor and key != pivot:
                    other[key] = other.get(key, 0.0) - factor * c
        own.append(pivot)
    largest = [max(abs(c) for c in row.values()) for row in rows]
    return [[(pivot, row[pivot])] + [(k, c) for k, c in row.items() if k != pivot and abs(c) > 1e-12 * big]
            for pivot, row, big in zip(own, rows, largest)]


def main(support, elements, kind):
    """Print the model."""
    nodes, bricks = {}, []
    for first in itertools.product(*(range(n) for n in elements)):
        at = [tuple(2 * f + o for f, o in zip(first, offset)) for offset in BRICK]
        bricks.append([nodes.setdefault(node, len(nodes) + 1) for node in at])
    print("*NODE, NSET=ALL")
    for node, number in nodes.items():
        print(number, *(f"{SIZE[d] * node[d] / (2 * elements[d]):.12g}" for d in range(3)), sep=", ")
    print(f"*ELEMENT, TYPE={kind}, ELSET=BEAM")
    for number, brick in enumerate(bricks, 1):
        print(number, *brick[:10], sep=", ", end=",\n")
        print(*brick[10:], sep=", ")
    print(f"*MATERIAL, NAME=M\n*ELASTIC\n{YOUNG:g}, {POISSON:g}\n*DENSITY\n{DENSITY:g}")
    print("*SOLID SECTION, ELSET=BEAM, MATERIAL=M")
    if support.startswith("held"):
        foot = {node: number for node, number in nodes.items() if node[0] == 0}
        print("*BOUNDARY", *(f"{number}, {1 if support == 'held' else 2}, 3" for number in foot.values()), sep="\n")
        for node, number in foot.items() if support == "held-hinge" else ():
            height = node[2] / elements[2] - 1  # u_x of the upper edge's end, by which the face turns
            if node != (0, 0, 2 * elements[2]):
                terms = f"{number}, 1, 1\n{nodes[0, 0, 2 * elements[2]]}, 1, {-height:.12e}"
                print("*EQUATION", 2 if height else 1, terms if height else f"{number}, 1, 1", sep="\n")
    else:
        ends = [0, 2 * elements[0]] if support == "hinges" else [0]
        kept = range(6) if support == "clamp" else [0, 1, 2, 3, 5]
        for equation in itertools.chain(*(reduced(mean_conditions(elements, x, kept)) for x in ends)):
            print(f"*EQUATION\n{len(equation)}")
            for (node, direction), c in equation:
                print(f"{nodes[node]}, {direction}, {c:.12e}")
    print("*STEP\n*FREQUENCY\n8\n*END STEP")


if __name__ == "__main__":
    main(sys.argv[1], [int(n) for n in sys.argv[2:5]], sys.argv[5] if len(sys.argv) > 5 else "C3D20")
