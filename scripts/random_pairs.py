#!/usr/bin/env python3
"""Draw pairs of bodies at random out of the catalogue of shapes, let them collide with default settings, and sort what comes of it.

Usage: random_pairs.py FOLDER [--fbimpact PROGRAM] [--kind axial|plane|solid|mesh|part|rigid] [--pairs FIRST..LAST] [--quick] [--laws] [--fine] [--limit SECONDS]
                       [--memory GB] [--list]

Pair NUMBER of a kind is the same scenario on every machine: FOLDER/KIND-NUMBER.toml, its result beside it. Sizes are 5 to 200 mm, proportions up to 5:1,
speeds 1 cm/s to 1 m/s, materials by name or drawn; odd numbers have friction 0.3, others none. Half of the plane and solid bodies stand in any pose, the
others turned by multiples of 45 degrees about the axes, so that faces, edges and corners meet as well. The first body of a pair of kind `mesh` is of
hexahedra, of `rigid` both are rigid and meet by Hertz's law. Both of `part` are what CAD gives: solids with and without round edges or with a bore, in
quadratic tetrahedra of Gmsh with its default sizes (needs Gmsh's Python module; the same meshes for the same version of it); pair NUMBER with friction
is pair NUMBER - 1 once more. All other keys are left out; --quick gives few elements and modes, so that most pairs take
seconds and hundreds can be tried: how contacts are found, refined and left does not depend on them. --laws draws the model of the contact, its zone and
damping, too. --fine runs each pair whose zone does not vibrate again with accuracy "fine" and
compares peak, impulse and duration. A line for each pair, with its seconds of processor, goes to FOLDER/KIND.txt, one for all of a coefficient of friction to the end:

  ok          simulated; momentum of free pairs kept to 1e-10, energy ledger to 1e-5, of parts and with friction to 1e-4; no failure
  told        off from the fine run by more than 2 %, and a band or its lack or a warning says so
  silent      off by more without a word: a fault
  apart       simulated, the bodies did not meet (hollow ones)
  refused     by `fbimpact check` as by the run, with its reason
  guarded     ended by a check whose remedy is to leave the drawn model or zone out
  late        refused or failed in the run though `check` has no word: a fault
  momentum, ledger  off by more: a fault
  crash       panic or another unknown end: a fault
  slow, memory  stopped at the limits given

Exit code 1 if there is a fault.
"""

import argparse
import itertools
import json
import math
import os
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile

MATERIALS = ["steel", "stainless-steel", "cast-iron", "aluminium", "titanium", "copper", "brass", "glass"]
ELASTICITY = {"steel": (210e9, 0.3, 7850), "stainless-steel": (200e9, 0.3, 7900), "cast-iron": (110e9, 0.26, 7200), "aluminium": (70e9, 0.3, 2700),
              "titanium": (113.8e9, 0.342, 4430), "copper": (129.8e9, 0.343, 8960), "brass": (100.6e9, 0.35, 8530), "glass": (70e9, 0.2, 2500)}
MOMENTUM, LEDGER, LEDGER_OF_FRICTION, FINE = 1e-10, 1e-5, 1e-4, 0.02
# What checks of a run tell whoever gives a model or a zone.
REMEDIES = ("leave contacts.touch.model out", 'choose model = "adaptive"', "widen the interval", "model out if an edge may touch")
FAULTS = ("late", "momentum", "ledger", "crash", "silent")
# Warnings that speak of elements and modes that --quick gives, of output or of materials: none says that the force is off.
BESIDE = {"coarse-mesh", "few-modes", "sparse-output", "coarse-place", "yields", "local-stress", "large-contact-strain", "large-strain", "large-turn"}


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def scaled(a, s):
    return [s * x for x in a]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def unit(a):
    return scaled(a, 1.0 / math.sqrt(dot(a, a)))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(q, v, sign=1.0):
    """The vector `v` turned by the quaternion `q` = [w, x, y, z], or back by it with `sign` -1."""
    u = scaled(q[1:], sign)
    t = scaled(cross(u, v), 2.0)
    return plus(v, plus(scaled(t, q[0]), cross(u, t)))


def of_any_size(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


class Body:
    """A body of the pair: its shape with numbers, pose, material, and what of them the placing needs."""

    def __init__(self, rng, kind, shapes, is_rigid):
        self.kind, self.shape, self.is_rigid = kind, rng.choice(shapes), is_rigid
        self.keys, self.position, self.velocity = {}, [0.0] * 3, [0.0] * 3
        self.thickness = of_any_size(rng, 5e-3, 0.2)
        self.pose(rng)
        self.draw_shape(rng)
        self.nodes, self.ending, self.volume_of_nodes = [], "msh" if kind == "part" else "inp", 0.0
        if kind == "mesh":
            self.draw_mesh(rng)
        elif kind == "part":
            self.draw_part(rng)
        if rng.random() < 0.5:
            self.material = rng.choice(MATERIALS)
            self.elasticity = ELASTICITY[self.material]
        else:
            self.material = None
            self.elasticity = (of_any_size(rng, 1e9, 400e9), rng.uniform(0.0, 0.45), of_any_size(rng, 1e3, 20e3))
        self.mass = self.elasticity[2] * self.volume()

    def pose(self, rng):
        """Quaternion: none of axial bodies, any or a turn by multiples of 45 degrees of others."""
        self.rotation, any_pose = [1.0, 0.0, 0.0, 0.0], rng.random() < 0.5
        about_z = rng.uniform(0, 2 * math.pi) if any_pose else 0.25 * math.pi * rng.randrange(8)
        if self.kind == "plane":
            self.rotation = [math.cos(0.5 * about_z), 0.0, 0.0, math.sin(0.5 * about_z)]
        elif self.kind != "axial" and any_pose:
            self.rotation = unit([rng.gauss(0, 1) for _ in range(4)])
        elif self.kind != "axial":
            axis = rng.choice([[1, 0, 0], [0, 1, 0], [0, 0, 1]])
            self.rotation = [math.cos(0.5 * about_z), *scaled(axis, math.sin(0.5 * about_z))]

    def draw_shape(self, rng):
        size = of_any_size(rng, 5e-3, 0.2)
        ratio = lambda: of_any_size(rng, 0.2, 1.0)
        keys, shape = self.keys, self.shape
        if shape in ("sphere", "disc"):
            keys["radius"] = 0.5 * size
            if self.kind == "solid" and not self.is_rigid and rng.random() < 0.5:
                keys["net"] = rng.choice(["cube", "spindle", "shells"])
        elif shape == "ellipsoid":
            keys["semi_axes"] = [0.5 * size * ratio() for _ in range(3)]
        elif shape == "torus":
            keys["outer_radius"] = 0.5 * size
            keys["inner_radius"] = keys["outer_radius"] * rng.uniform(0.3, 0.7)
        elif shape in ("rod", "cylinder", "capsule", "cone", "rod-spherical-end", "hollow-cylinder"):
            r, length = (0.5 * size, size * ratio()) if rng.random() < 0.5 else (0.5 * size * ratio(), size)
            if shape == "rod-spherical-end":
                length = max(length, 1.2 * r)
            keys["length"] = length
            if shape == "hollow-cylinder":
                keys.update(inner_radius=r * rng.uniform(0.2, 0.8), outer_radius=r)
            else:
                keys["radius"] = r
        else:
            keys["size"] = [size * ratio() for _ in range(2 if shape == "rectangle" else 3)]

    def draw_mesh(self, rng):
        """Nodes and file of a box of hexahedra, or of one blown up to an ellipsoid, whose corners are then those of the mesh."""
        n = [rng.randint(2, 5) for _ in range(3)]
        half = [0.5 * s for s in self.keys["size"]] if "size" in self.keys else self.keys.get("semi_axes") or [self.keys["radius"]] * 3
        number = lambda i, j, k: 1 + i + (n[0] + 1) * (j + (n[1] + 1) * k)
        for k, j, i in itertools.product(*(range(n[a] + 1) for a in (2, 1, 0))):
            at = [2.0 * c / m - 1.0 for c, m in zip((i, j, k), n)]
            if "size" not in self.keys:
                a = [c * c for c in at]
                at = [at[i] * math.sqrt(1 - 0.5 * (a[i - 1] + a[i - 2]) + a[i - 1] * a[i - 2] / 3) for i in range(3)]
            self.nodes.append([c * h for c, h in zip(at, half)])
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        elements = [[number(*(x + y for x, y in zip((i, j, k), c))) for c in corners] for i, j, k in itertools.product(*map(range, n))]
        rows, cells = ([", ".join(map(repr, [i, *x])) for i, x in enumerate(of, 1)] for of in (self.nodes, elements))
        self.mesh = "\n".join(["*NODE", *rows, "*ELEMENT, TYPE=C3D8, ELSET=ALL", *cells, ""]).encode()

    def draw_part(self, rng):
        """Nodes and file of a solid of quadratic tetrahedra, sides by Gmsh's default; half of those with edges have them round, a third of the boxes a bore.

        No nodes where Gmsh finds no round edges or no mesh.
        """
        import gmsh
        import numpy

        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Verbosity", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        k, shape, occ = self.keys, self.shape, gmsh.model.occ
        if shape in ("sphere", "ellipsoid"):
            solid = occ.addSphere(0, 0, 0, 1)
            occ.dilate([(3, solid)], 0, 0, 0, *(k.get("semi_axes") or [k["radius"]] * 3))
        elif shape == "torus":
            solid = occ.addTorus(0, 0, 0, 0.5 * (k["outer_radius"] + k["inner_radius"]), 0.5 * (k["outer_radius"] - k["inner_radius"]))
        elif shape == "cone":
            solid = occ.addCone(0, 0, 0, 0, 0, k["length"], k["radius"], k["radius"] * rng.uniform(0.2, 0.8))
        elif shape == "box":
            solid = occ.addBox(*scaled(k["size"], -0.5), *k["size"])
            if rng.random() < 1 / 3:
                bore = occ.addCylinder(0, 0, -k["size"][2], 0, 0, 2 * k["size"][2], rng.uniform(0.15, 0.35) * min(k["size"][:2]))
                solid = occ.cut([(3, solid)], [(3, bore)])[0][0][1]
        else:
            solid = occ.addCylinder(0, 0, 0, 0, 0, k["length"], k["radius"])
            if shape == "capsule":
                ends = [(3, occ.addSphere(0, 0, z, k["radius"])) for z in (0, k["length"])]
                solid = occ.fuse([(3, solid)], ends)[0][0][1]
        occ.synchronize()
        if shape in ("box", "cylinder", "cone") and rng.random() < 0.5:
            edges = [tag for _, tag in gmsh.model.getBoundary(gmsh.model.getBoundary([(3, solid)]), False, False)]
            least = min(k.get("size") or [2 * k["radius"] * 0.2, k["length"]])
            try:
                occ.fillet([solid], sorted(set(edges)), [rng.uniform(0.05, 0.15) * least])
            except Exception:  # of Gmsh: "Could not compute fillet"
                gmsh.finalize()
                return
            occ.synchronize()
        box = gmsh.model.getBoundingBox(3, solid)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.1 * math.dist(box[:3], box[3:]))
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.model.mesh.generate(3)
        tags, at, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(11)
        _, sides = gmsh.model.mesh.getElementsByType(9)
        gmsh.option.setNumber("Mesh.Binary", 1)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "part.msh")
            gmsh.write(str(file))
            self.mesh = file.read_bytes()
        gmsh.finalize()
        if len(corners) == 0:
            return
        nodes = numpy.zeros((int(max(tags)) + 1, 3))
        nodes[tags.astype(int)] = numpy.reshape(at, (-1, 3))
        self.nodes = nodes.tolist()
        # Points of the curved sides, which reach beyond their nodes: an eighth of a side apart.
        grid = [(i / 8, j / 8, (8 - i - j) / 8) for i in range(9) for j in range(9 - i)]
        shapes = numpy.array([[a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a] for a, b, c in grid])
        self.surface = numpy.einsum("ga,sax->sgx", shapes, nodes[numpy.reshape(sides, (-1, 6)).astype(int)]).reshape(-1, 3)
        a, b, c, d = nodes[numpy.reshape(corners, (-1, 10)).T[:4].astype(int)]
        self.volume_of_nodes = float(numpy.sum(numpy.cross(b - a, c - a) * (d - a)) / 6)

    def volume(self):
        k, shape = self.keys, self.shape
        if self.kind == "part":
            return self.volume_of_nodes
        if shape == "sphere":
            return 4 / 3 * math.pi * k["radius"] ** 3
        if shape == "disc":
            return math.pi * k["radius"] ** 2 * self.thickness
        if shape == "ellipsoid":
            return 4 / 3 * math.pi * math.prod(k["semi_axes"])
        if shape == "hollow-cylinder":
            return math.pi * (k["outer_radius"] ** 2 - k["inner_radius"] ** 2) * k["length"]
        if shape == "rod-spherical-end":
            return math.pi * k["radius"] ** 2 * (k["length"] - k["radius"] / 3)
        if "size" in k:
            return math.prod(k["size"]) * (self.thickness if shape == "rectangle" else 1.0)
        return math.pi * k["radius"] ** 2 * k["length"]

    def support(self, direction):
        """Largest distance along the unit vector `direction` of points of the body from its origin."""
        n, k = turned(self.rotation, direction, -1.0), self.keys
        if self.kind == "part":
            return float((self.surface @ n).max())
        if self.nodes and "size" not in k:
            return max(dot(n, x) for x in self.nodes)
        if "size" in k:
            return 0.5 * sum(s * abs(c) for s, c in zip(k["size"], n))
        if "semi_axes" in k:
            return math.sqrt(sum((s * c) ** 2 for s, c in zip(k["semi_axes"], n)))
        if "length" in k:
            return k.get("radius", k.get("outer_radius")) * math.hypot(n[0], n[1]) + max(0.0, k["length"] * n[2])
        return k["radius"]

    def size(self):
        """A length of the body's middle size."""
        return (self.volume() / (self.thickness if self.kind == "plane" else 1.0)) ** (0.5 if self.kind == "plane" else 1 / 3)

    def end_over(self, r, side):
        """z of the axial body's lower (-1) or upper (+1) end at the radius `r`; None where there is none."""
        k, outer = self.keys, self.keys.get("radius", self.keys.get("outer_radius"))
        if r > outer or r < k.get("inner_radius", 0.0):
            return None
        if self.shape == "sphere":
            return side * math.sqrt(outer * outer - r * r)
        if side > 0:
            return k["length"]
        return outer - math.sqrt(outer * outer - r * r) if self.shape == "rod-spherical-end" else 0.0

    def table(self, pair, name, is_quick):
        model = {"axial": "axisymmetric", "plane": "plane-strain", "mesh": "mesh", "part": "mesh"}.get(self.kind, "solid")
        lines = [f"[bodies.{name}]", f'model = "{"rigid" if self.is_rigid else model}"']
        if self.is_rigid and self.kind in ("axial", "plane"):
            lines.append(f'motion = "{"axial" if self.kind == "axial" else "planar"}"')
        lines.append(f'material = "{self.material or "of-" + name}"')
        if self.kind == "plane":
            lines.append(f"thickness = {self.thickness!r}")
        geometry = ", ".join(f"{key} = {json.dumps(value)}" for key, value in {"shape": self.shape, **self.keys}.items())
        lines += [f"geometry = {{ {geometry} }}" if not self.nodes else f'file = "{pair}-{name}.{self.ending}"\nunits = "m"', f"position = {self.position!r}", f"velocity = {self.velocity!r}"]
        if self.kind != "axial":
            lines.append(f"orientation = {self.rotation!r}")
        if is_quick and not self.is_rigid:
            lines += [f"reduction = {{ modes = {20 if self.kind == 'solid' else 10} }}"]
            lines += [f"discretisation = {{ elements = {4 if self.kind == 'solid' else 6} }}"] if not self.nodes else []
        if not self.material:
            e, nu, rho = self.elasticity
            lines += [f"[materials.of-{name}]", f"youngs_modulus = {e!r}", f"poissons_ratio = {nu!r}", f"density = {rho!r}"]
        return lines


SHAPES = {"axial": ["sphere", "rod", "rod-spherical-end", "hollow-cylinder"], "plane": ["rectangle", "disc"],
          "solid": ["sphere", "ellipsoid", "cylinder", "hollow-cylinder", "box"], "mesh": ["box", "ellipsoid"],
          "part": ["sphere", "ellipsoid", "cylinder", "cone", "capsule", "box", "box", "torus"], "rigid": ["sphere", "ellipsoid"]}
MODELS = ["adaptive"] * 6 + ["quasistatic"] * 4 + ["massless", "coarse", "hertz", "hertz", "damped", "dynamic"]


def directions(rng, kind):
    """A unit vector in the plane of the model or in space."""
    if kind == "axial":
        return [0.0, 0.0, -1.0]
    if kind == "plane":
        a = rng.uniform(0, 2 * math.pi)
        return [math.cos(a), math.sin(a), 0.0]
    return unit([rng.gauss(0, 1) for _ in range(3)])


def travel_to_touch(rng, first, second, way):
    """Way of `first` along the unit vector `way` until the convex hulls meet, first at the origin, second at its position; None if they pass.

    It is the largest over normals `n` with `n·way > 0` of the gap along `n` over `n·way`, a quasiconvex function, climbed by random steps: what is
    found is never too long.
    """
    reach = lambda n: (dot(n, second.position) - first.support(n) - second.support(scaled(n, -1.0))) / max(dot(n, way), 1e-9)
    best, at, step = -math.inf, way, 1.0
    plane = first.kind == "plane"
    for turn in range(6000):
        n = plus(at, scaled([rng.gauss(0, 1), rng.gauss(0, 1), 0.0 if plane else rng.gauss(0, 1)], step))
        n = unit(n)
        if dot(n, way) <= 1e-6:
            continue
        value = reach(n)
        if value > best:
            best, at = value, n
        elif turn % 12 == 11:
            step = max(0.75 * step, 1e-9) if turn % 600 else 0.5
    # Hulls that a normal across the way parts do not meet.
    across = unit(plus(at, scaled(way, -dot(at, way) + 1e-12)))
    passes = dot(across, second.position) - first.support(across) - second.support(scaled(across, -1.0)) > 0.0
    return None if passes or dot(at, way) < 0.05 else best, at


def first_gap(rng, kind, body):
    """Gap that the bodies begin with; more of parts, whose sides bulge a little beyond their nodes."""
    return rng.uniform(0.0, 2e-4) + (1e-3 * body.size() if kind == "part" else 0.0)


def place(rng, kind, first, second, speed):
    """Put the two bodies a little apart, the first flying at the second; returns the time of touch."""
    way = directions(rng, kind)
    gap = first_gap(rng, kind, first)
    if kind == "axial":
        radii = sorted({r * f for body in (first, second) for key, r in body.keys.items() if key.endswith("radius") for f in
                        [i / 400 for i in range(401)]})
        ends = [(first.end_over(r, -1), second.end_over(r, 1)) for r in radii]
        gaps = [a - b for a, b in ends if a is not None and b is not None]
        if not gaps:
            return None
        first.position = [0.0, 0.0, gap - min(gaps)]
        first.velocity = [0.0, 0.0, -speed]
        return gap / speed
    across = unit(plus(directions(rng, kind), scaled(way, 1e-9)))
    across = plus(across, scaled(way, -dot(across, way)))
    offset = rng.choice([0.0, rng.uniform(-0.4, 0.4)]) * (first.size() + second.size())
    second.position = plus(scaled(way, 10.0), scaled(across, offset))
    found = travel_to_touch(rng, first, second, way)
    if found[0] is None:
        return None
    travel, _ = found
    first.position = scaled(way, travel - gap)
    shift = scaled(second.position, -1.0)
    first.position, second.position = plus(first.position, shift), [0.0] * 3
    first.velocity = scaled(way, speed)
    return gap / speed


def place_on_plane(rng, kind, body, speed):
    """Put the body over a plane through the origin; returns the plane's normal and the time of touch."""
    normal = scaled(directions(rng, kind), -1.0)
    if kind != "axial" and rng.random() < 0.5:
        normal = [0.0, 1.0, 0.0] if kind == "plane" else [0.0, 0.0, 1.0]
    gap = first_gap(rng, kind, body)
    lowest = body.end_over(body.keys.get("inner_radius", 0.0), -1) if kind == "axial" else -body.support(scaled(normal, -1.0))
    body.position = scaled(normal, gap - lowest)
    body.velocity = scaled(normal, -speed)
    if kind != "axial":
        side = directions(rng, kind)
        body.velocity = plus(body.velocity, scaled(plus(side, scaled(normal, -dot(side, normal))), speed * rng.uniform(0.0, 1.0)))
    return normal, gap / speed


def order_of_impact(first, second, speed):
    """Hertz's impact of balls as large as the bodies: contact radius \\[m\\], and the time with that of waves \\[s\\]; no more than their order."""
    bodies = [b for b in (first, second) if b]
    mass = 1.0 / sum(1.0 / b.mass for b in bodies)
    modulus = 1.0 / sum((1 - b.elasticity[1] ** 2) / b.elasticity[0] for b in bodies)
    radius = 1.0 / sum(2.0 / b.size() for b in bodies)
    waves = max(max(b.keys.get("size", [b.keys.get("length", b.size())])) * math.sqrt(b.elasticity[2] / b.elasticity[0]) for b in bodies)
    time_of_hertz = 2.87 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2
    return math.sqrt(radius * speed * time_of_hertz / 2.94), time_of_hertz + 4.0 * waves


def law(number, kind, radius):
    """Keys of the contact of pair `number`, whose contact radius is some `radius`."""
    rng = random.Random(f"law-{kind}-{number}")
    is_dear = kind in ("mesh", "solid", "part") and rng.random() < 0.6
    model = "hertz" if kind == "rigid" else "adaptive" if is_dear else rng.choice(MODELS)
    lines = [f'model = "{model}"']
    if model in ("damped", "dynamic") or model in ("quasistatic", "massless") and rng.random() < 0.5:
        lines.append(f"interval = {{ width = {radius * of_any_size(rng, 2.0, 16.0)!r}, elements = {rng.randint(4, 16)} }}")
    if rng.random() < 0.15:
        lines.append(f"damping = {rng.uniform(0.0, 1.0)!r}")
    return model, lines


class Pair:
    """Pair `number` of a kind, its scenario and what of it the balance needs."""

    def __init__(self, kind, number, arguments):
        rng, is_quick = random.Random(f"{kind}-{number // 2 if kind == 'part' else number}"), arguments.quick
        touch = None
        while touch is None:
            partner = rng.choice(["flexible", "flexible", "flexible" if kind == "part" else "rigid", "plane"])
            speed = of_any_size(rng, 0.01, 1.0)
            first = Body(rng, kind, SHAPES[kind], kind == "rigid")
            others = "solid" if kind == "mesh" and (partner == "rigid" or rng.random() < 0.5) else kind
            second = None if partner == "plane" else Body(rng, others, SHAPES[others], partner == "rigid" or kind == "rigid")
            normal = None
            if kind == "part" and not all(body.nodes for body in (first, second) if body):
                continue
            if second:
                touch = place(rng, kind, first, second, speed)
            else:
                normal, touch = place_on_plane(rng, kind, first, speed)
        self.name, self.bodies = f"{kind}-{number}", [b for b in (first, second) if b]
        self.is_free, self.friction = second is not None, 0.3 if number % 2 else 0.0
        radius, duration = order_of_impact(first, second, speed)
        lines = [f'title = "{self.name}"', "[simulation]", f"end_time = {touch + 10 * duration!r}", "stop_after_impacts = 1"]
        for name, body in zip(("first", "second"), self.bodies):
            lines += body.table(self.name, name, is_quick)
        if not second:
            lines += ["[bodies.second]", 'model = "rigid"', 'geometry = { shape = "plane" }', f"normal = {normal!r}"]
        swapped = partner == "flexible" and rng.random() < 0.5
        lines += ["[contacts.touch]", 'contact_body = "%s"' % ("second" if swapped else "first"),
                  'target_body = "%s"' % ("first" if swapped else "second")]
        if self.friction:
            lines.append(f"friction = {self.friction}")
        self.model, keys = law(number, kind, radius) if arguments.laws or kind == "rigid" else ("adaptive", [])
        lines += keys
        if is_quick and kind in ("solid", "mesh", "part") and self.model == "adaptive":
            lines.append("interval = { elements = 8 }")
        self.text = "\n".join(lines) + "\n"
        names = [f"{'rigid ' if b.is_rigid else 'meshed ' if b.nodes else ''}{b.shape}" for b in self.bodies]
        self.what = " on ".join(names + ([] if second else ["plane"])) + f", {self.model} {self.friction:g}"

    def scale_of_momentum(self):
        """Sizes of linear and angular momentum about the origin: what sums of the bodies' own are rounded at."""
        linear = sum(b.mass * math.sqrt(dot(b.velocity, b.velocity)) for b in self.bodies)
        arm = max(math.sqrt(dot(b.position, b.position)) + b.size() for b in self.bodies)
        return linear, linear * arm


# Seconds of processor and GB of each run.
COSTS = []


def answer(command, limit=60):
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    return done.returncode, done.stdout, done.stderr


def first_fault(text):
    lines = [line for line in text.splitlines() if not line.startswith((" INFO", " WARN"))]
    return " ".join(lines[:2])[:400] if lines else ""


def simulated(path, result, arguments, *more):
    """Exit code, negative where it was ended by a signal, and log of a run; what it took is the last of `COSTS`."""
    command = [arguments.fbimpact, "run", "-q", str(path), "-o", str(result), "--no-cache", "--force", "--threads", "1", "--memory", str(arguments.memory)]
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (arguments.limit, arguments.limit + 5))
    with subprocess.Popen([*command, *more], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=limit) as run:
        err = run.stderr.read()
        _, status, used = os.wait4(run.pid, 0)
        code = run.returncode = os.waitstatus_to_exitcode(status)
    COSTS.append((used.ru_utime + used.ru_stime, used.ru_maxrss / 1e6))
    path.with_suffix(".log").write_text(err, encoding="utf-8")
    return code, err


def outcome(pair, folder, arguments):
    """Class and words of what comes of a pair."""
    path, result = folder / f"{pair.name}.toml", folder / f"{pair.name}.h5"
    path.write_text(pair.text, encoding="utf-8")
    for name, body in zip(("first", "second"), pair.bodies):
        if body.nodes:
            (folder / f"{pair.name}-{name}.{body.ending}").write_bytes(body.mesh)
    if arguments.list:
        return "listed", ""
    code, err = simulated(path, result, arguments)
    if code in (130, -signal.SIGXCPU, -signal.SIGKILL):  # the program stops at the first signal as at an interrupt
        return "slow", ""
    if "panic" in err or code not in (0, 3, 4, 5):
        return "crash", f"exit code {code}: {first_fault(err)}"
    if code:
        is_refused = code != 5 and answer([arguments.fbimpact, "check", str(path)])[0] == code
        is_guarded = pair.model != "adaptive" and any(remedy in err for remedy in REMEDIES)
        return "refused" if is_refused else "memory" if "memory" in err else "guarded" if is_guarded else "late", first_fault(err)
    info = json.loads(answer([arguments.fbimpact, "info", "--json", str(result)])[1])
    name, words = balance(pair, info, result, arguments)
    if name == "ok" and arguments.fine and pair.model not in ("damped", "dynamic"):
        name, more = beside_fine(info, path, result, arguments)
        words += f" {more}"
    return name, words


def beside_fine(info, path, result, arguments):
    """Whether peak, impulse and duration are those of the run with accuracy "fine", or what says that they are not."""
    code, err = simulated(path, result.with_suffix(".fine.h5"), arguments, "--set", 'accuracy="fine"')
    if code:
        return "ok", f"fine: exit code {code} {first_fault(err)}"
    fine = json.loads(answer([arguments.fbimpact, "info", "--json", str(result.with_suffix(".fine.h5"))])[1])
    if not fine["impacts"]:
        return "silent", "fine: none"
    told, words, row, other = True, "", info["impacts"][0], fine["impacts"][0]
    warned = {w["identifier"] for w in info["warnings"]} - BESIDE
    for key in ("peak_force", "impulse", "duration"):
        off, band = abs(row[key] / other[key] - 1.0), row[key + "_uncertainty"]
        words += f" {key} {row[key] / other[key] - 1.0:+.1%}" + (f" band {band / row[key]:.1%}" if band is not None else "")
        told &= off <= FINE or band is None or bool(warned) or band / row[key] >= off
        if off > FINE:
            words += "!"
    return "silent" if not told else "told" if "!" in words else "ok", "fine:" + words


def balance(pair, info, result, arguments):
    words = f"drift {info['energy_drift']:.1e}"
    if not info["impacts"]:
        return "apart", words
    words += f" restitution {info['impacts'][0]['restitution']} trials {len(info['tries'])}"
    warned = sorted({w["identifier"] for w in info["warnings"]})
    if warned:
        words += f" warnings {' '.join(warned)}"
    if pair.is_free:
        expressions = [f"{name}=max(norm(momentum.{name} - momentum.{name}[0]))" for name in ("linear", "angular")]
        values = json.loads(answer([arguments.fbimpact, "metric", str(result), *expressions])[1])
        changes = [values[name]["value"] / scale for name, scale in zip(("linear", "angular"), pair.scale_of_momentum())]
        words += " momentum " + " ".join(f"{c:.0e}" for c in changes)
        if max(changes) > MOMENTUM:
            return "momentum", words
    most = LEDGER if not pair.friction and pair.bodies[0].kind != "part" else LEDGER_OF_FRICTION
    return ("ledger" if info["energy_drift"] > most else "ok"), words


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--fbimpact", default="fbimpact")
    parser.add_argument("--kind", choices=sorted(SHAPES), action="append")
    parser.add_argument("--pairs", default="0..100")
    parser.add_argument("--quick", action="store_true", help="few elements and modes")
    parser.add_argument("--laws", action="store_true", help="draw the model of the contact")
    parser.add_argument("--fine", action="store_true", help="compare with accuracy fine")
    parser.add_argument("--limit", type=int, default=120, help="seconds of processor that a run may take")
    parser.add_argument("--memory", type=float, default=6.0, help="GB that a run may take")
    parser.add_argument("--list", action="store_true", help="write the scenarios only")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder)
    folder.mkdir(parents=True, exist_ok=True)
    counts, runs = {}, []
    for kind in arguments.kind or sorted(SHAPES):
        for number in range(*map(int, arguments.pairs.split(".."))):
            pair = Pair(kind, number, arguments)
            COSTS.clear()
            name, words = outcome(pair, folder, arguments)
            counts[name] = counts.get(name, 0) + 1
            cost = COSTS[0] if COSTS else (0.0, 0.0)
            runs.append((pair.friction, name, *cost))
            line = f"{pair.name:10} {name:8} {cost[0]:6.1f} s {cost[1]:4.1f} GB  {pair.what}  {words}"
            print(line, flush=True)
            with open(folder / f"{kind}.txt", "a", encoding="utf-8") as table:
                table.write(line + "\n")
    for friction in sorted({run[0] for run in runs}):
        of = [run for run in runs if run[0] == friction]
        ended = [run for run in of if run[1] in ("ok", "told", "silent", "apart", "ledger", "momentum")]
        seconds, memory = sorted(run[2] for run in ended) or [0.0], max((run[3] for run in ended), default=0.0)
        print(f"friction {friction:g}: {len(of)} pairs, {len(ended)} end, median {seconds[len(seconds) // 2]:.1f} s, slowest {seconds[-1]:.1f} s, {memory:.1f} GB")
    print("  ".join(f"{name} {count}" for name, count in sorted(counts.items())))
    sys.exit(1 if any(name in counts for name in FAULTS) else 0)


if __name__ == "__main__":
    main()
