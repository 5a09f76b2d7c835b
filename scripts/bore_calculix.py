#!/usr/bin/env python3
"""A ball that hits the wall of a bore of nearly its own radius: force and duration by finite elements of CalculiX on a mesh of their own (docs/verification.md).

Usage: bore_calculix.py [FOLDER] [--parts A B C] [--level N] [--step SECONDS] [--penalty K] [--ball MM] [--csv FILE]; needs ccx on the path, numpy, scipy
and pypardiso (pip install pypardiso).

Steel ball of 9.9 mm in the bore of 10 mm of a free ring (outer radius 20 mm, length 30 mm), at 0.1 m/s along a radius, in the ring's middle. A quarter of
both bodies by symmetry, graded hexahedra with curved sides (C3D20). CalculiX gives stiffness and mass (*FREQUENCY, SOLVER=MATRIXSTORAGE) of each body with
its planes of symmetry held; here they are integrated in time by the HHT method (alpha = -0.05, CalculiX' own), all degrees of freedom of both bodies, with a
linear pressure over overclosure of PENALTY N/mm^3 at 3 x 3 points of each side of the ball's elements. The contact is implicit: one factorisation a body
gives the compliance of a step at those points, and Newton's method for the points alone ends when none of them opens or closes any more. Gaps are distances
to the bore along its radii, displacements are small (3 um at 10 mm). Without CalculiX' contact: a step of that takes some ten factorisations.

--parts gives the numbers of elements over the half contact along and across the bore, and below it; --level multiplies the numbers elsewhere.
Prints peak, duration, impulse, restitution, momentum and energy; --csv writes the history.
"""

import argparse
import math
import os
import pathlib
import subprocess
import tempfile

import numpy
import pypardiso
import scipy.sparse
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

YOUNG, POISSON, DENSITY = 2.1e5, 0.3, 7.85e-9  # N, mm, t, s
BORE, OUTER, LENGTH = 10.0, 20.0, 30.0  # mm
SPEED, GAP = 100.0, 5e-5  # mm/s, mm
PARTS = [5, 8, 4]
ALPHA = -0.05
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
SIDES = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]  # S1 to S6


def hertz(ball, force):
    """Half axes along and across the bore's circumference [mm] and approach [mm] of Hertz' elliptic contact."""
    narrow, wide = 1.0 / ball, 1.0 / ball - 1.0 / BORE
    modulus = YOUNG / (1 - POISSON**2) / 2
    ratio = lambda k: ((ellipe(1 - k * k) / k**2 - ellipk(1 - k * k)) / (ellipk(1 - k * k) - ellipe(1 - k * k))) - narrow / wide
    k = brentq(ratio, 1e-3, 0.999999)  # across over along
    e = 1 - k * k
    a = (3 * force * ellipe(e) / (math.pi * k * k * modulus * (narrow + wide))) ** (1 / 3)
    return a, k * a, 3 * force * ellipk(e) / (2 * math.pi * modulus * a)


def graded(fine, count, end, ratio, least):
    """0 to `end`: `count` equal parts up to `fine`, then parts that grow by `ratio`, `least` or more."""
    step, rest = fine / count, end - fine
    n = max(least, math.ceil(math.log(1 + rest * (ratio - 1) / (step * ratio)) / math.log(ratio)))
    r = brentq(lambda q: step * sum(q**i for i in range(1, n + 1)) - rest, 0.3, 20.0)
    return numpy.concatenate([numpy.linspace(0, fine, count + 1), fine + step * numpy.cumsum(r ** numpy.arange(1, n + 1))])


class Mesh:
    """Nodes and hexahedra of 20 nodes of blocks that are mapped from grids."""

    def __init__(self, first_node, first_element):
        self.places, self.known, self.elements, self.sides = [], {}, [], {}
        self.first_node, self.first_element = first_node, first_element

    def node(self, place):
        key = tuple(int(round(x * 1e7)) for x in place)
        for k in [key] + [tuple(a + b for a, b in zip(key, d)) for d in NEAR]:
            if k in self.known:
                return self.known[k]
        self.known[key] = len(self.places)
        self.places.append(place)
        return self.known[key]

    def block(self, grids, place):
        a, b, c = grids
        for i in range(len(a) - 1):
            for j in range(len(b) - 1):
                for k in range(len(c) - 1):
                    ends = ((a[i], a[i + 1]), (b[j], b[j + 1]), (c[k], c[k + 1]))
                    at = [[ends[d][corner[d]] for d in range(3)] for corner in CORNERS]
                    at += [[0.5 * (at[p][d] + at[q][d]) for d in range(3)] for p, q in EDGES]
                    places = [place(*x) for x in at]
                    jacobian = numpy.linalg.det([numpy.subtract(places[n], places[0]) for n in (1, 3, 4)])
                    assert jacobian > 0, (ends, jacobian)
                    self.elements.append([self.node(p) for p in places])

    def arrays(self):
        self.places = numpy.array(self.places)
        self.elements = numpy.array(self.elements)
        self.weights = self.lumped()
        return self

    def lumped(self):
        """Integrals of the nodes' functions: the mean of a field is their sum with its values, over the volume."""
        g = math.sqrt(0.6)
        rule = [((x, y, z), u * v * w) for x, u in LINE(g) for y, v in LINE(g) for z, w in LINE(g)]
        signs = [[2 * c - 1 for c in corner] for corner in CORNERS]
        signs += [[(signs[p][d] + signs[q][d]) / 2 for d in range(3)] for p, q in EDGES]
        total = numpy.zeros(len(self.places))
        for at, weight in rule:
            n, dn = functions(signs, at)
            jacobians = numpy.einsum("kd,eki->edi", dn, self.places[self.elements])
            numpy.add.at(total, self.elements.ravel(), numpy.outer(numpy.linalg.det(jacobians), weight * n).ravel())
        return total

    def faces(self, wanted):
        """Sides of elements all of whose corners fulfil `wanted`."""
        good = numpy.array([wanted(p) for p in self.places])
        return [(e + self.first_element, s + 1) for e, own in enumerate(self.elements) for s, side in enumerate(SIDES) if all(good[own[k]] for k in side)]

    def lines(self, name):
        lines = [f"*NODE, NSET={name}"]
        lines += [f"{n + self.first_node}, {x:.12e}, {y:.12e}, {z:.12e}" for n, (x, y, z) in enumerate(self.places)]
        lines.append(f"*ELEMENT, TYPE=C3D20, ELSET={name}")
        for e, own in enumerate(self.elements):
            words = [str(e + self.first_element)] + [str(n + self.first_node) for n in own]
            lines += [", ".join(words[:11]) + ",", ", ".join(words[11:])]
        return lines

    def on(self, direction):
        return [n + self.first_node for n in range(len(self.places)) if abs(self.places[n][direction]) < 1e-7]


NEAR = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) != (0, 0, 0)]


def LINE(g):
    return [(-g, 5 / 9), (0.0, 8 / 9), (g, 5 / 9)]


def functions(signs, at):
    n, dn = [], []
    for s in signs:
        f = [1 + s[d] * at[d] if s[d] else 1 - at[d] ** 2 for d in range(3)]
        df = [s[d] if s[d] else -2 * at[d] for d in range(3)]
        product, slopes = f[0] * f[1] * f[2], [df[0] * f[1] * f[2], f[0] * df[1] * f[2], f[0] * f[1] * df[2]]
        if all(s):
            last = sum(s[d] * at[d] for d in range(3)) - 2
            n.append(product * last / 8)
            dn.append([(slopes[d] * last + product * s[d]) / 8 for d in range(3)])
        else:
            n.append(product / 4)
            dn.append([x / 4 for x in slopes])
    return numpy.array(n), numpy.array(dn)


def meshes(ball, level, parts, gap):
    """Quarters (y, z > 0) of the ball, its lowest point at x = BORE - gap, and of the ring with its axis at the origin."""
    along, across, _ = hertz(ball, 200.0)
    count = lambda n: max(2, round(n * level))
    ratio = 2.4 ** (1 / level)
    arc = graded(1.25 * along, parts[0], ball * math.pi / 4, ratio, count(2))
    narrow = graded(1.35 * across, parts[1], ball * math.pi / 4, ratio, count(3))
    depth = graded(1.5 * across, parts[2], 0.6 * ball, ratio, count(3))
    half = Mesh(1, 1)
    core, shift = 0.4, BORE - gap - ball
    quarter = math.pi / 4
    u = numpy.linspace(-1, 1, count(3) + 1)
    v, w, s = arc / (ball * quarter), narrow / (ball * quarter), 1 - depth[::-1] / depth[-1]
    s[0], s[-1], v[-1], w[-1] = 0.0, 1.0, 1.0, 1.0
    tan = lambda x: math.tan(quarter * x)

    def shell(x, y, z, s):
        inner, size = core * ball, math.sqrt(x * x + y * y + z * z)
        radius = (1 - s) * inner + (s * ball / size if s else 0.0)
        return [radius * x + shift, radius * y, radius * z]

    half.block((u, v, w), lambda a, b, c: shell(tan(a), tan(b), tan(c), 0.0))
    half.block((s, v, w), lambda a, b, c: shell(1.0, tan(b), tan(c), a))
    half.block((-s[::-1], v, w), lambda a, b, c: shell(-1.0, tan(b), tan(c), -a))
    half.block((u, s, w), lambda a, b, c: shell(tan(a), 1.0, tan(c), b))
    half.block((u, v, s), lambda a, b, c: shell(tan(a), tan(b), 1.0, c))
    half.arrays()
    ring = Mesh(len(half.places) + 1, len(half.elements) + 1)
    end = math.pi * BORE
    around = numpy.concatenate([arc, graded(arc[-1] - arc[-2], 1, end - arc[-1], ratio, count(5))[1:] + arc[-1]])
    lengthwise = graded(1.35 * across, parts[1], 0.5 * LENGTH, ratio, count(3))
    outward = graded(1.5 * across, parts[2], OUTER - BORE, ratio, count(3))

    def wall(r, a, z):
        return [(BORE + r) * math.cos(a / BORE), (BORE + r) * math.sin(a / BORE), z]

    ring.block((outward, around, lengthwise), wall)
    ring.arrays()
    centre = (shift, 0.0, 0.0)
    touched = half.faces(lambda p: abs(numpy.linalg.norm(p - centre) - ball) < 1e-6 and p[0] > shift and abs(p[1]) < 1.55 * along and p[2] < 2.2 * across)
    return half, ring, touched, (around, lengthwise)


# The direction that is fixed on each side, and its value.
FIXED = [(2, -1), (2, 1), (1, -1), (0, 1), (1, 1), (0, -1)]
SIGNS = [[2 * c - 1 for c in corner] for corner in CORNERS]
SIGNS += [[(SIGNS[p][d] + SIGNS[q][d]) / 2 for d in range(3)] for p, q in EDGES]


class Body:
    """Stiffness and mass of a mesh by CalculiX, and the state of its motion."""

    def __init__(self, mesh, folder, name):
        self.mesh = mesh
        lines = mesh.lines("PART") + ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG}, {POISSON}", "*DENSITY", f"{DENSITY}"]
        lines.append("*SOLID SECTION, ELSET=PART, MATERIAL=STEEL")
        for direction, plane in ((1, "MIDY"), (2, "MIDZ")):
            lines += [f"*NSET, NSET={plane}"] + [f"{n}," for n in mesh.on(direction)]
        lines += ["*BOUNDARY", "MIDY, 2, 2", "MIDZ, 3, 3", "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "12", "*END STEP"]
        (folder / f"{name}.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
        with open(folder / f"{name}.log", "w", encoding="utf-8") as log:
            subprocess.run(["ccx", name], cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"}, check=False, stdout=log, stderr=log)
        labels = [line.split(".") for line in (folder / f"{name}.dof").read_text(encoding="utf-8").split()]
        self.number = {(int(n) - mesh.first_node, int(d) - 1): i for i, (n, d) in enumerate(labels)}
        count = len(labels)

        def matrix(ending):
            i, j, x = numpy.loadtxt(folder / f"{name}.{ending}", unpack=True)
            i, j = i.astype(int) - 1, j.astype(int) - 1
            other = i != j
            return scipy.sparse.csr_matrix((numpy.r_[x, x[other]], (numpy.r_[i, j[other]], numpy.r_[j, i[other]])), shape=(count, count))

        self.stiffness, self.mass = matrix("sti"), matrix("mas")
        self.along = numpy.zeros(count)
        for (n, d), i in self.number.items():
            if d == 0:
                self.along[i] = 1.0
        self.u, self.v, self.a = numpy.zeros(count), numpy.zeros(count), numpy.zeros(count)
        self.total = 4 * self.along @ self.mass @ self.along
        rigid = abs(self.stiffness @ self.along).max() / abs(self.stiffness).max()
        print(f"{name}: {count} degrees of freedom, mass {1e3 * self.total:.6f} kg, force of a rigid motion {rigid:.0e}", flush=True)

    def prepare(self, step, points):
        """Factorises the matrix of a step; `points` are (nodes, weights, direction) where forces act."""
        self.step, self.beta, self.gamma = step, (1 - ALPHA) ** 2 / 4, 0.5 - ALPHA
        self.inertia = self.mass / (self.beta * step**2)
        matrix = (self.inertia + (1 + ALPHA) * self.stiffness).tocsr()
        rows, columns, values = [], [], []
        for k, (nodes, weights, direction) in enumerate(points):
            for n, w in zip(nodes, weights):
                for d in range(3):
                    if abs(w * direction[d]) > 1e-14 and (n, d) in self.number:
                        rows.append(self.number[n, d])
                        columns.append(k)
                        values.append(w * direction[d])
        self.points = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(matrix.shape[0], len(points)))
        self.solver = pypardiso.PyPardisoSolver()
        self.matrix = matrix
        self.solver.factorize(matrix)
        parts = [numpy.asarray(self.solve(numpy.asfortranarray(self.points[:, k : k + 64].toarray()))) for k in range(0, len(points), 64)]
        self.answer = (1 + ALPHA) * numpy.hstack(parts)
        self.compliance = self.points.T @ self.answer
        self.force = numpy.zeros(len(points))

    def solve(self, b):
        return self.solver.solve(self.matrix, b)

    def free(self):
        """Displacements at the end of a step without the forces of its end."""
        self.predicted = self.u + self.step * self.v + self.step**2 * (0.5 - self.beta) * self.a
        right = self.inertia @ self.predicted + ALPHA * (self.stiffness @ self.u) - ALPHA * (self.points @ self.force)
        self.next = self.solve(right)
        return self.points.T @ self.next

    def finish(self, force):
        u = self.next + self.answer @ force
        a = (u - self.predicted) / (self.beta * self.step**2)
        self.v = self.v + self.step * ((1 - self.gamma) * self.a + self.gamma * a)
        self.u, self.a, self.force = u, a, force

    def velocity(self):
        """Of the centre of mass [mm/s]."""
        return 4 * self.along @ (self.mass @ self.v) / self.total

    def energy(self):
        return 2 * (self.v @ (self.mass @ self.v) + self.u @ (self.stiffness @ self.u))


def pairs(half, ring, touched, grids):
    """Points of contact: those of the ball, those of the bore (nodes, weights, direction), gaps at the start, areas."""
    around, lengthwise = grids
    columns, layers = len(around) - 1, len(lengthwise) - 1
    ball, bore, gaps, areas = [], [], [], []
    for e, side in touched:
        own = half.elements[e - half.first_element]
        fixed, value = FIXED[side - 1]
        free = [d for d in range(3) if d != fixed]
        for x, p in LINE(math.sqrt(0.6)):
            for y, q in LINE(math.sqrt(0.6)):
                at = [0.0, 0.0, 0.0]
                at[fixed], at[free[0]], at[free[1]] = value, x, y
                n, dn = functions(SIGNS, at)
                place, slopes = n @ half.places[own], dn.T @ half.places[own]
                areas.append(p * q * numpy.linalg.norm(numpy.cross(slopes[free[0]], slopes[free[1]])))
                angle = math.atan2(place[1], place[0])
                direction = (math.cos(angle), math.sin(angle), 0.0)
                gaps.append(BORE - math.hypot(place[0], place[1]))
                ball.append((own, n, direction))
                i = int(numpy.searchsorted(around, BORE * angle) - 1)
                k = int(numpy.searchsorted(lengthwise, place[2]) - 1)
                r = 2 * (BORE * angle - around[i]) / (around[i + 1] - around[i]) - 1
                s = 2 * (place[2] - lengthwise[k]) / (lengthwise[k + 1] - lengthwise[k]) - 1
                n, _ = functions(SIGNS, [-1.0, r, s])
                bore.append((ring.elements[i * layers + k], n, direction))
    return ball, bore, numpy.array(gaps), numpy.array(areas)


def pressed(gaps, compliance, springs):
    """Forces of springs that push where gaps close: gap = `gaps` + `compliance` force."""
    force = numpy.zeros(len(gaps))
    active = gaps < 0
    for _ in range(100):
        k = numpy.flatnonzero(active)
        force[:] = 0.0
        if len(k):
            force[k] = numpy.linalg.solve(numpy.diag(1 / springs[k]) + compliance[numpy.ix_(k, k)], -gaps[k])
        now = gaps + compliance @ force
        new = numpy.where(active, force > 0, now < 0)
        if numpy.array_equal(new, active):
            return force
        active = new
    raise RuntimeError("points open and close without end")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--parts", type=int, nargs=3, default=PARTS)
    parser.add_argument("--level", type=float, default=1.0)
    parser.add_argument("--step", type=float, nargs="+", default=[2e-7], help="[s]; several for several runs")
    parser.add_argument("--penalty", type=float, default=1e9, help="[N/mm^3]")
    parser.add_argument("--ball", type=float, default=9.9, help="radius [mm]")
    parser.add_argument("--csv")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    half, ring, touched, grids = meshes(arguments.ball, arguments.level, arguments.parts, GAP)
    print(f"{len(half.places)} + {len(ring.places)} nodes, {len(half.elements)} + {len(ring.elements)} elements, {len(touched)} sides that may touch", flush=True)
    bodies = [Body(half, folder, "ball"), Body(ring, folder, "ring")]
    ball, bore, gaps, areas = pairs(half, ring, touched, grids)
    print(f"{len(gaps)} points, smallest gap {1e3 * gaps.min():.4f} um, area {areas.sum():.4f} mm^2")
    for step in arguments.step:
        for body, points in zip(bodies, (ball, bore)):
            body.u[:], body.a[:] = 0.0, 0.0
            body.v = SPEED * body.along if body is bodies[0] else numpy.zeros(len(body.u))
            body.prepare(step, points)
        start = sum(b.total * b.velocity() for b in bodies), sum(b.energy() for b in bodies)
        compliance = bodies[0].compliance + bodies[1].compliance
        history, time, widest = [(0.0, 0.0)], 0.0, (0.0, 0.0)
        while time < 3e-4:
            time += step
            free = [body.free() for body in bodies]
            force = pressed(gaps + free[1] - free[0], compliance, arguments.penalty * areas)
            bodies[0].finish(-force)
            bodies[1].finish(force)
            history.append((time, 4 * float(sum(f * d[2][0] for f, d in zip(force, bore)))))
            if force.sum() > 0:
                own = [sum(w * half.places[n] for w, n in zip(ball[k][1], ball[k][0])) for k in numpy.flatnonzero(force)]
                widest = tuple(max(w, max(p[d] for p in own)) for w, d in zip(widest, (1, 2)))
            elif time > 3e-5 and sum(h[1] > 0 for h in history) > 10:
                break
        t, f = numpy.array(history).T
        best, closed = int(numpy.argmax(f)), numpy.flatnonzero(f > 0)
        top = numpy.polyfit(t[best - 2 : best + 3] - t[best], f[best - 2 : best + 3], 2)
        # Ends by f^(2/3), which is nearly linear there.
        ends = []
        for a, b in ((closed[1], closed[2]), (closed[-2], closed[-3])):
            x, y = f[a] ** (2 / 3), f[b] ** (2 / 3)
            ends.append(t[a] - (t[b] - t[a]) * x / (y - x))
        impulse = float(numpy.sum(0.5 * (f[1:] + f[:-1]) * numpy.diff(t)))
        after = sum(b.total * b.velocity() for b in bodies), sum(b.energy() for b in bodies)
        print(f"step {step:.2e} s: peak {f[best]:.3f} N (parabola {top[2] - top[1] ** 2 / 4 / top[0]:.3f} N), duration {1e6 * (ends[1] - ends[0]):.3f} us (points closed "
              f"{1e6 * (t[closed[-1]] - t[closed[0]]):.2f} us), impulse {impulse:.6e} N s, restitution {(bodies[1].velocity() - bodies[0].velocity()) / SPEED:.5f}; "
              f"momentum {after[0] / start[0] - 1:+.1e}, energy {after[1] / start[1] - 1:+.1e}, contact to {widest[0]:.3f} by {widest[1]:.4f} mm", flush=True)
    if arguments.csv:
        with open(arguments.csv, "w", encoding="utf-8") as out:
            out.write("time_us,force_N\n")
            out.writelines(f"{1e6 * (a - ends[0]):.4f},{b:.4f}\n" for a, b in zip(t, f))


if __name__ == "__main__":
    main()
