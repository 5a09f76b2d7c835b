#!/usr/bin/env python3
"""Draw pairs of bodies at random out of the catalogue of shapes, let them collide with default settings, and sort what comes of it.

Usage: random_pairs.py FOLDER [--fbimpact PROGRAM] [--kind axial|plane|solid] [--pairs FIRST..LAST] [--quick] [--limit SECONDS] [--memory GB] [--list]

Pair NUMBER of a kind is the same scenario on every machine: FOLDER/KIND-NUMBER.toml, its result beside it. Sizes are 5 to 200 mm, proportions up to 5:1,
speeds 1 cm/s to 1 m/s, materials by name or drawn; odd numbers have friction 0.3, others none. Half of the plane and solid bodies stand in any pose, the
others turned by multiples of 45 degrees about the axes, so that faces, edges and corners meet as well. All other keys are left out; --quick gives few
elements and modes, so that most pairs take seconds and hundreds can be tried: how contacts are found, refined and left does not depend on them. A line for each pair goes to FOLDER/KIND.txt:

  ok          simulated; momentum of free pairs kept to 1e-10, energy ledger to 1e-4, no failure
  apart       simulated, the bodies did not meet (hollow ones)
  refused     by `fbimpact check`, with its reason
  late        refused or failed in the run though `check` had no word: a fault
  momentum, ledger  off by more: a fault
  crash       panic or another unknown end: a fault
  slow, memory  stopped at the limits given

Exit code 1 if there is a fault.
"""

import argparse
import json
import math
import pathlib
import random
import subprocess
import sys
import time

MATERIALS = ["steel", "stainless-steel", "cast-iron", "aluminium", "titanium", "copper", "brass", "glass"]
ELASTICITY = {"steel": (210e9, 0.3, 7850), "stainless-steel": (200e9, 0.3, 7900), "cast-iron": (110e9, 0.26, 7200), "aluminium": (70e9, 0.3, 2700),
              "titanium": (113.8e9, 0.342, 4430), "copper": (129.8e9, 0.343, 8960), "brass": (100.6e9, 0.35, 8530), "glass": (70e9, 0.2, 2500)}
MOMENTUM, LEDGER = 1e-10, 1e-4
FAULTS = ("late", "momentum", "ledger", "crash")


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
        elif self.kind == "solid" and any_pose:
            self.rotation = unit([rng.gauss(0, 1) for _ in range(4)])
        elif self.kind == "solid":
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
        elif shape in ("rod", "cylinder", "rod-spherical-end", "hollow-cylinder"):
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

    def volume(self):
        k, shape = self.keys, self.shape
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

    def table(self, name, is_quick):
        model = {"axial": "axisymmetric", "plane": "plane-strain", "solid": "solid"}[self.kind]
        lines = [f"[bodies.{name}]", f'model = "{"rigid" if self.is_rigid else model}"']
        if self.is_rigid and self.kind != "solid":
            lines.append(f'motion = "{"axial" if self.kind == "axial" else "planar"}"')
        lines.append(f'material = "{self.material or "of-" + name}"')
        if self.kind == "plane":
            lines.append(f"thickness = {self.thickness!r}")
        geometry = ", ".join(f"{key} = {json.dumps(value)}" for key, value in {"shape": self.shape, **self.keys}.items())
        lines += [f"geometry = {{ {geometry} }}", f"position = {self.position!r}", f"velocity = {self.velocity!r}"]
        if self.kind != "axial":
            lines.append(f"orientation = {self.rotation!r}")
        if is_quick and not self.is_rigid:
            lines += [f"discretisation = {{ elements = {4 if self.kind == 'solid' else 6} }}", f"reduction = {{ modes = {20 if self.kind == 'solid' else 10} }}"]
        if not self.material:
            e, nu, rho = self.elasticity
            lines += [f"[materials.of-{name}]", f"youngs_modulus = {e!r}", f"poissons_ratio = {nu!r}", f"density = {rho!r}"]
        return lines


SHAPES = {"axial": ["sphere", "rod", "rod-spherical-end", "hollow-cylinder"], "plane": ["rectangle", "disc"],
          "solid": ["sphere", "ellipsoid", "cylinder", "hollow-cylinder", "box"]}


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


def place(rng, kind, first, second, speed):
    """Put the two bodies a little apart, the first flying at the second; returns the time of touch."""
    way = directions(rng, kind)
    gap = rng.uniform(0.0, 2e-4)
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
        normal = {"plane": [0.0, 1.0, 0.0], "solid": [0.0, 0.0, 1.0]}[kind]
    gap = rng.uniform(0.0, 2e-4)
    lowest = body.end_over(body.keys.get("inner_radius", 0.0), -1) if kind == "axial" else -body.support(scaled(normal, -1.0))
    body.position = scaled(normal, gap - lowest)
    body.velocity = scaled(normal, -speed)
    if kind != "axial":
        side = directions(rng, kind)
        body.velocity = plus(body.velocity, scaled(plus(side, scaled(normal, -dot(side, normal))), speed * rng.uniform(0.0, 1.0)))
    return normal, gap / speed


def duration(first, second, speed):
    """Hertz's impact of balls as large as the bodies, and the time of waves through them: no more than the order of the impact's time \\[s\\]."""
    bodies = [b for b in (first, second) if b]
    mass = 1.0 / sum(1.0 / b.mass for b in bodies)
    modulus = 1.0 / sum((1 - b.elasticity[1] ** 2) / b.elasticity[0] for b in bodies if not b.is_rigid)
    radius = 1.0 / sum(2.0 / b.size() for b in bodies)
    waves = max(max(b.keys.get("size", [b.keys.get("length", b.size())])) * math.sqrt(b.elasticity[2] / b.elasticity[0]) for b in bodies)
    return 2.87 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2 + 4.0 * waves


class Pair:
    """Pair `number` of a kind, its scenario and what of it the balance needs."""

    def __init__(self, kind, number, is_quick):
        rng = random.Random(f"{kind}-{number}")
        touch = None
        while touch is None:
            partner = rng.choice(["flexible", "flexible", "rigid", "plane"])
            speed = of_any_size(rng, 0.01, 1.0)
            first = Body(rng, kind, SHAPES[kind], False)
            second = None if partner == "plane" else Body(rng, kind, SHAPES[kind], partner == "rigid")
            normal = None
            if second:
                touch = place(rng, kind, first, second, speed)
            else:
                normal, touch = place_on_plane(rng, kind, first, speed)
        self.name, self.bodies = f"{kind}-{number}", [b for b in (first, second) if b]
        self.is_free = second is not None
        lines = [f'title = "{self.name}"', "[simulation]", f"end_time = {touch + 10 * duration(first, second, speed)!r}", "stop_after_impacts = 1"]
        lines += first.table("first", is_quick)
        if second:
            lines += second.table("second", is_quick)
        else:
            lines += ["[bodies.second]", 'model = "rigid"', 'geometry = { shape = "plane" }', f"normal = {normal!r}"]
        swapped = partner == "flexible" and rng.random() < 0.5
        lines += ["[contacts.touch]", 'contact_body = "%s"' % ("second" if swapped else "first"),
                  'target_body = "%s"' % ("first" if swapped else "second")]
        if number % 2:
            lines.append("friction = 0.3")
        if is_quick and kind == "solid":
            lines.append("interval = { elements = 8 }")
        self.text = "\n".join(lines) + "\n"
        self.what = " on ".join([f"{'rigid ' if b.is_rigid else ''}{b.shape}" for b in self.bodies] + ([] if second else ["plane"]))

    def scale_of_momentum(self):
        """Sizes of linear and angular momentum about the origin: what sums of the bodies' own are rounded at."""
        linear = sum(b.mass * math.sqrt(dot(b.velocity, b.velocity)) for b in self.bodies)
        arm = max(math.sqrt(dot(b.position, b.position)) + b.size() for b in self.bodies)
        return linear, linear * arm


def answer(command, limit=60):
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    return done.returncode, done.stdout, done.stderr


def first_fault(text):
    lines = [line for line in text.splitlines() if not line.startswith((" INFO", " WARN"))]
    return " ".join(lines[:2])[:400] if lines else ""


def outcome(pair, program, folder, arguments):
    """Class and words of what comes of a pair."""
    path, result = folder / f"{pair.name}.toml", folder / f"{pair.name}.h5"
    path.write_text(pair.text, encoding="utf-8")
    if arguments.list:
        return "listed", ""
    code, out, err = answer([program, "check", str(path)])
    if code:
        return ("refused" if code in (3, 4) else "crash"), first_fault(err + out)
    # The program is asked to stop, and ended if it does not.
    command = ["timeout", "-k", "20", "-s", "INT", str(arguments.limit), program, "run", "-q", str(path), "-o", str(result), "--no-cache", "--force",
               "--threads", "1", "--memory", str(arguments.memory)]
    code, _, err = answer(command, None)
    (folder / f"{pair.name}.log").write_text(err, encoding="utf-8")
    if code in (124, 130, 137):
        return "slow", ""
    if "panic" in err or code not in (0, 4, 5):
        return "crash", f"exit code {code}: {first_fault(err)}"
    if code:
        return ("memory" if "memory" in err else "late"), first_fault(err)
    return balance(pair, program, result, err)


def balance(pair, program, result, log):
    info = json.loads(answer([program, "info", "--json", str(result)])[1])
    words = f"drift {info['energy_drift']:.1e}"
    if not info["impacts"]:
        return "apart", words
    words += f" restitution {info['impacts'][0]['restitution']} trials {len(info['tries'])}"
    warned = sorted({w["identifier"] for w in info["warnings"]})
    if warned:
        words += f" warnings {' '.join(warned)}"
    if pair.is_free:
        expressions = [f"{name}=max(norm(momentum.{name} - momentum.{name}[0]))" for name in ("linear", "angular")]
        values = json.loads(answer([program, "metric", str(result), *expressions])[1])
        changes = [values[name]["value"] / scale for name, scale in zip(("linear", "angular"), pair.scale_of_momentum())]
        words += " momentum " + " ".join(f"{c:.0e}" for c in changes)
        if max(changes) > MOMENTUM:
            return "momentum", words
    return ("ledger" if info["energy_drift"] > LEDGER else "ok"), words


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--fbimpact", default="fbimpact")
    parser.add_argument("--kind", choices=sorted(SHAPES), action="append")
    parser.add_argument("--pairs", default="0..100")
    parser.add_argument("--quick", action="store_true", help="few elements and modes")
    parser.add_argument("--limit", type=int, default=120, help="seconds that a run may take")
    parser.add_argument("--memory", type=float, default=6.0, help="GB that a run may take")
    parser.add_argument("--list", action="store_true", help="write the scenarios only")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder)
    folder.mkdir(parents=True, exist_ok=True)
    counts = {}
    for kind in arguments.kind or sorted(SHAPES):
        for number in range(*map(int, arguments.pairs.split(".."))):
            pair, started = Pair(kind, number, arguments.quick), time.monotonic()
            name, words = outcome(pair, arguments.fbimpact, folder, arguments)
            counts[name] = counts.get(name, 0) + 1
            line = f"{pair.name:10} {name:8} {time.monotonic() - started:6.1f} s  {pair.what}  {words}"
            print(line, flush=True)
            with open(folder / f"{kind}.txt", "a", encoding="utf-8") as table:
                table.write(line + "\n")
    print("  ".join(f"{name} {count}" for name, count in sorted(counts.items())))
    sys.exit(1 if any(name in counts for name in FAULTS) else 0)


if __name__ == "__main__":
    main()
