#!/usr/bin/env python3
"""Write the mesh of a small connecting rod: hexahedra with twenty nodes, in Gmsh's format (MSH 4.1, text), in millimetres.

Usage: connecting_rod.py [FILE]; the default is scenarios/connecting_rod.msh. Two eyes about (0, 0) and (80, 0), 8 mm thick from z = -4 to 4, with a
shank between them. Groups: "rod" (volume), "big eye" and "small eye" (the holes).
"""

import math
import pathlib
import sys

DEFAULT = pathlib.Path(__file__).resolve().parent.parent / "scenarios/connecting_rod.msh"
LENGTH, THICKNESS = 80.0, 8.0
BIG, SMALL = (8.0, 14.0), (5.0, 9.0)  # radii of hole and eye
SECTORS, RINGS, SHANK, HEIGHT, LAYERS = 12, 1, 6, 2, 1
# Edges of hexahedra, those of their twenty nodes in the middle, in the order of Gmsh.
EDGES = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]
CUBE = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]


def eye(radii, centre, side):
    """A place of the plane by radial and angular half steps; towards the shank (side 1 or -1) the rim is a chord."""
    def place(i, j):
        angle = 2 * math.pi * j / (2 * SECTORS) - math.pi / 6
        inner = [radii[0] * c for c in (math.cos(angle), math.sin(angle))]
        outer = [radii[1] * c for c in (math.cos(angle), math.sin(angle))]
        if angle <= math.pi / 6 + 1e-9:
            outer = [radii[1] * math.cos(math.pi / 6), radii[1] * 0.5 * angle / (math.pi / 6)]
        x, y = (a + (b - a) * i / (2 * RINGS) for a, b in zip(inner, outer))
        return centre + side * x, side * y

    return place


def shank(i, j):
    s, t = i / (2 * SHANK), j / HEIGHT - 1
    left = BIG[1] * math.cos(math.pi / 6), BIG[1] * math.sin(math.pi / 6)
    right = LENGTH - SMALL[1] * math.cos(math.pi / 6), SMALL[1] * math.sin(math.pi / 6)
    return left[0] + s * (right[0] - left[0]), t * (left[1] + s * (right[1] - left[1]))


def main():
    numbers, points, elements, faces = {}, [], [], {"big eye": [], "small eye": []}

    def node(x, y, k):
        z = THICKNESS * (k / (2 * LAYERS) - 0.5)
        key = tuple(round(1e6 * c) for c in (x, y, z))
        if key not in numbers:
            numbers[key] = len(points) + 1
            points.append((x, y, z))
        return numbers[key]

    def block(place, n, hole=None, periodic=False):
        for k in range(0, 2 * LAYERS, 2):
            for i in range(0, 2 * n[0], 2):
                for j in range(0, 2 * n[1], 2):
                    wrap = 2 * n[1] if periodic else 10**9

                    def at(a, b, c):
                        x, y = place(i + a, (j + b) % wrap)
                        return node(x, y, k + c)

                    corners = [at(*c) for c in CUBE]
                    middles = [at(*((CUBE[a][d] + CUBE[b][d]) // 2 for d in range(3))) for a, b in EDGES]
                    elements.append(corners + middles)
                    if hole and i == 0:
                        quad = [(0, 0, 0), (0, 0, 2), (0, 2, 2), (0, 2, 0), (0, 0, 1), (0, 1, 2), (0, 2, 1), (0, 1, 0)]
                        faces[hole].append([at(*c) for c in quad])

    block(eye(BIG, 0.0, 1), (RINGS, SECTORS), "big eye", True)
    block(eye(SMALL, LENGTH, -1), (RINGS, SECTORS), "small eye", True)
    block(shank, (SHANK, HEIGHT))
    write(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT, points, elements, faces)


def write(path, points, elements, faces):
    out = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", "3"]
    out += ['2 1 "big eye"', '2 2 "small eye"', '3 1 "rod"', "$EndPhysicalNames", "$Entities", "0 0 2 1"]
    box = " ".join(f"{f(p[d] for p in points):.6g}" for f in (min, max) for d in range(3))
    out += [f"1 {box} 1 1 0", f"2 {box} 1 2 0", f"1 {box} 1 1 2 1 2", "$EndEntities"]
    out += ["$Nodes", f"1 {len(points)} 1 {len(points)}", f"3 1 0 {len(points)}"]
    out += [str(i + 1) for i in range(len(points))]
    out += [" ".join(f"{x:.12g}" for x in p) for p in points] + ["$EndNodes"]
    total = len(elements) + sum(map(len, faces.values()))
    out += ["$Elements", f"3 {total} 1 {total}"]
    label = 1
    for dim, tag, kind, block in ((2, 1, 16, faces["big eye"]), (2, 2, 16, faces["small eye"]), (3, 1, 17, elements)):
        out.append(f"{dim} {tag} {kind} {len(block)}")
        for nodes in block:
            out.append(" ".join(map(str, [label] + nodes)))
            label += 1
    path.write_text("\n".join(out + ["$EndElements", ""]))


if __name__ == "__main__":
    main()
