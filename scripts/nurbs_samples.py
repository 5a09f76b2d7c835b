#!/usr/bin/env python3
"""Writes the splines that the tests of iga-core read, in the forms of MFEM and G+Smo.

MFEM itself (pip install mfem) numbers the nodes of the pipe and the ball; the ball is one that fbimpact exported:
    fbimpact export-body ball.toml --body ball --nurbs mfem --units mm -o shells.mesh

Usage: scripts/nurbs_samples.py shells.mesh crates/iga-core/tests/files
"""

import pathlib
import re
import sys
import tempfile

import mfem.ser as mfem

ROOT_HALF = 0.5**0.5
# The control points of a full circle of radius one.
CIRCLE = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
INNER, OUTER, LENGTH = 8.0, 10.0, 30.0  # mm


def renumbered(text, folder):
    """The mesh as MFEM writes it: weights and nodes in its order."""
    given, written = folder / "given.mesh", folder / "written.mesh"
    given.write_text(text)
    mfem.Mesh(str(given), 1, 1).Print(str(written))
    return re.sub(r"#[^\n]*\n", "", written.read_text())


def shuffled(text, order):
    """A mesh in the form with patches, its patches in another order and every second one turned about its own third axis."""
    head, *patches = re.split(r"\nknotvectors\n", text)
    lines = head.split("\n")
    first = lines.index("elements") + 2
    elements = lines[first : first + len(patches)]
    edges = lines.index("edges")
    new_elements, new_patches = [], []
    for place, p in enumerate(order):
        attribute, kind, *v = elements[p].split()
        body = patches[p].split("\n")
        if place % 2:
            # (xi, eta) -> (eta, 1 - xi): vertex 3 becomes the first, knots change places, the second reversed.
            v = [v[i] for i in (3, 0, 1, 2, 7, 4, 5, 6)]
            knots = [line.split() for line in body[1:4]]
            n = [int(k[1]) for k in knots]
            at = body.index("controlpoints_cartesian") + 1
            points = body[at : at + n[0] * n[1] * n[2]]
            net = [
                points[j + n[0] * ((n[1] - 1 - i) + n[1] * k)] for k in range(n[2]) for j in range(n[0]) for i in range(n[1])
            ]
            reverse = knots[1][:2] + [repr(1 - float(u)) for u in reversed(knots[1][2:])]
            new_knots = [" ".join(k) for k in (reverse, knots[0], knots[2])]
            body = ["3", *new_knots, *body[4:at], *net, ""]
        new_elements.append(" ".join([attribute, kind, *v]))
        new_patches.append("\n".join(body))
    head = lines[:first] + new_elements + ["", "boundary", "0", ""] + lines[edges:]
    return "\nknotvectors\n".join(["\n".join(head), *new_patches])


def pipe():
    """Four quarters, the third one against the others."""
    def vertices(q):
        return [q, 4 + q, 4 + (q + 1) % 4, (q + 1) % 4]  # at z = 0: inner, outer, next outer, next inner
    elements, patches = [], []
    for q in range(4):
        v = vertices(q) + [8 + i for i in vertices(q)]
        points = []
        for z in (0.0, LENGTH):
            for k in range(3):
                x, y = CIRCLE[(2 * q + k) % 8]
                for r in (INNER, OUTER):
                    points.append((r * x, r * y, z, 1.0 if k != 1 else ROOT_HALF))
        if q == 2:
            v = [v[i] for i in (2, 3, 0, 1, 6, 7, 4, 5)]  # half a turn about z
            points = list(reversed(points[:6])) + list(reversed(points[6:]))
        elements.append("1 5 " + " ".join(map(str, v)))
        text = "\n".join(" ".join(map(repr, p)) for p in points)
        knots = "3\n1 2 0 0 1 1\n2 3 0 0 0 1 1 1\n1 2 0 0 1 1"
        patches.append(f"knotvectors\n{knots}\n\ndimension\n3\n\ncontrolpoints_cartesian\n{text}\n")
    head = "MFEM NURBS mesh v1.0\n\ndimension\n3\n\nelements\n4\n" + "\n".join(elements)
    return head + "\n\nboundary\n0\n\nedges\n0\n\nvertices\n16\n\npatches\n\n" + "\n".join(patches)


def tube():
    """One patch around a seam: left-handed, angles over [0, 4], a comment before the declaration."""
    points, weights = [], []
    for z in (0.0, LENGTH):
        for r in (INNER, OUTER):
            for k in range(9):
                x, y = CIRCLE[k % 8]
                points.append((r * x, r * y, z))
                weights.append(1.0 if k % 2 == 0 else ROOT_HALF)
    def basis(i, p, knots):
        return f'    <Basis type="BSplineBasis" index="{i}">\n     <KnotVector degree="{p}">{knots}</KnotVector>\n    </Basis>\n'
    linear = "0 0 1 1"
    return (
        "<!-- a tube of one patch -->\n<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<xml>\n"
        ' <Geometry type="TensorNurbs3" id="0">\n  <Basis type="TensorNurbsBasis3">\n'
        f"   <weights>{' '.join(map(repr, weights))}</weights>\n"
        '   <Basis type="TensorBSplineBasis3">\n'
        + basis(0, 2, "0 0 0 1 1 2 2 3 3 4 4 4")
        + basis(1, 1, linear)
        + basis(2, 1, linear)
        + "   </Basis>\n  </Basis>\n  <coefs geoDim=\"3\">\n"
        + "\n".join(" ".join(map(repr, p)) for p in points)
        + "\n  </coefs>\n </Geometry>\n</xml>\n"
    )


def main():
    shells, target = sys.argv[1:]
    target = pathlib.Path(target)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        ball = shuffled(pathlib.Path(shells).read_text(), [3, 0, 5, 1, 6, 2, 4])
        (target / "ball_nodes.mesh").write_text(renumbered(ball, folder))
        (target / "pipe_nodes.mesh").write_text(renumbered(pipe(), folder))
    (target / "tube.xml").write_text(tube())


if __name__ == "__main__":
    main()
