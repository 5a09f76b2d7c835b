#!/usr/bin/env python3
"""How often the truth lies within the bands of impacts, and how wide these are (docs/uncertainty.md).

    uncertainty_bench.py PROGRAM [--folder DIR] [--only TEXT] [--table FILE]

Every row is an impact: its numbers with their bands by the defaults, and the truth, a closed form or the same scenario, of meshes that of
the same shape of splines, with `accuracy = "fine"` and, by `[resolution]`, twice the modes, elements and points across, stiffer springs and a tenth of the tolerance. A
truth by refinement has an error of its own, which is not known: small errors and their ratios to bands are no sharper than that.
Needs h5py and numpy. Runs that are there already in DIR are not made again.
"""
import argparse
import json
import math
import pathlib
import random
import re
import subprocess
from typing import NamedTuple

import h5py
import numpy as np

STOP = "stop_after_impacts = 1\n"
OUTPUTS = ["peak_force", "peak_time", "duration", "impulse", "separation_velocity", "restitution"]
PEAKS = {"reaction_force": "joints", "reaction_moment": "joints", "position": "points", "von_mises": "points"}
SEEDS = (62, 63)
FINER = 'accuracy = "fine"\n[resolution]\nmodes = 2\nmesh = 2\nzone = 2\npenalty = 4.0\ntolerance = 0.1\n'


def body(name, model, geometry, position=None, velocity=None, material="steel", more=""):
    text = f'[bodies.{name}]\nmodel = "{model}"\n'
    if model != "rigid":
        text += f'material = "{material}"\n'
    text += f"geometry = {{ {geometry} }}\n"
    for key, value in (("position", position), ("velocity", velocity)):
        if value:
            text += f"{key} = {list(map(float, value))}\n"
    return text + more


def scenario(time, *bodies, contact=("a", "b"), extra="", materials=""):
    law = f'[contacts.c]\ncontact_body = "{contact[0]}"\ntarget_body = "{contact[1]}"\n{extra}'
    return f"[simulation]\nend_time = {time!r}\n{STOP}{materials}" + "".join(bodies) + law


def plane(normal=(0, 0, 1)):
    return body("b", "rigid", 'shape = "plane"', more=f"normal = {list(map(float, normal))}\n")


def ball_on_plane(radius, speed, material="steel"):
    ball = body("a", "axisymmetric", f'shape = "sphere", radius = {radius}', (0, 0, radius), (0, 0, -speed), material)
    return scenario(6e-2 * radius * speed**-0.2, ball, plane())


def ball_on_rod(radius, rod, speed, materials=("steel", "steel")):
    return scenario(
        8e-2 * radius * speed**-0.2,
        body("a", "axisymmetric", f'shape = "sphere", radius = {radius}', (0, 0, -radius), (0, 0, speed), materials[0]),
        body("b", "axisymmetric", f'shape = "rod", radius = {rod[0]}, length = {rod[1]}', material=materials[1]),
    )


def balls(radii, speed, materials=("steel", "steel")):
    a, b = radii
    return scenario(
        8e-2 * max(radii) * speed**-0.2,
        body("a", "axisymmetric", f'shape = "sphere", radius = {a}', (0, 0, -a), (0, 0, speed), materials[0]),
        body("b", "axisymmetric", f'shape = "sphere", radius = {b}', (0, 0, b), material=materials[1]),
    )


def discs(radii, speed, model="plane-strain"):
    a, b = radii
    return scenario(
        2e-2 * max(radii),
        body("a", model, f'shape = "disc", radius = {a}', (0, -a, 0), (0, speed, 0)),
        body("b", model, f'shape = "disc", radius = {b}', (0, b, 0)),
    )


def disc_on_plane(radius, speed):
    disc = body("a", "plane-strain", f'shape = "disc", radius = {radius}', (0, radius, 0), (0, -speed, 0))
    return scenario(2e-2 * radius, disc, plane((0, 1, 0)))


BAR = "[materials.bar]\nyoungs_modulus = 210e9\npoissons_ratio = 0.0\ndensity = 7850.0\n"


def bars(radius, lengths, speed, modes=None):
    more = f"[bodies.{{}}.reduction]\nmodes = {modes}\n" if modes else ""
    a, b = lengths
    return scenario(
        6e-4 * max(lengths),
        body("a", "axisymmetric", f'shape = "rod", radius = {radius}, length = {a}', (0, 0, -a), (0, 0, speed), "bar", more.format("a")),
        body("b", "axisymmetric", f'shape = "rod", radius = {radius}, length = {b}', None, None, "bar", more.format("b")),
        materials=BAR,
    )


def truth_of_bars(radius, lengths, speed):
    """Waves in bars of one section, the first the shorter one: it stays behind at rest."""
    c, area = math.sqrt(210e9 / 7850.0), math.pi * radius**2
    force, time = 0.5 * 7850.0 * c * area * speed, 2 * lengths[0] / c
    ratio = lengths[0] / lengths[1]
    return {"peak_force": force, "impulse": force * time, "separation_velocity": speed * ratio, "restitution": ratio}


def hertz(radius, speed):
    extra = 'model = "hertz"\n'
    more = f"mass = {4 / 3 * math.pi * radius**3 * 7850.0!r}\n"
    ball = (
        f'[bodies.a]\nmodel = "rigid"\nmaterial = "steel"\ngeometry = {{ shape = "sphere", radius = {radius} }}\n'
        f"position = [0.0, 0.0, {radius}]\nvelocity = [0.0, 0.0, {-speed}]\n"
    )
    floor = '[bodies.b]\nmodel = "rigid"\nmaterial = "steel"\ngeometry = { shape = "plane" }\n'
    return scenario(1e-4, ball, floor, extra=extra)


def block(model, size, speed, normal):
    half = 0.5 * size
    box = f'shape = "box", size = [{size}, {size}, {size}]' if model == "solid" else f'shape = "rectangle", size = [{size}, {size}]'
    axis = 2 if model == "solid" else 1
    position = [0.0, 0.0, 0.0]
    velocity = [0.0, 0.0, 0.0]
    position[axis], velocity[axis] = half, -speed
    return scenario(6e-4 * size, body("a", model, box, position, velocity), plane(normal))


ROWS = {}
for speed in (0.02, 0.05, 0.2, 0.5, 2.0):
    ROWS[f"ball on a plane, {speed} m/s"] = (ball_on_plane(0.01, speed), None)
for material in ("aluminium", "brass"):
    ROWS[f"ball of {material} on a plane"] = (ball_on_plane(0.01, 0.2, material), None)
for speed in (0.1, 0.5, 2.0):
    ROWS[f"ball on a rod, {speed} m/s"] = (ball_on_rod(0.01, (0.01, 0.3), speed), None)
ROWS["ball on a short rod"] = (ball_on_rod(0.01, (0.008, 0.05), 0.5), None)
ROWS["small ball on a thick rod"] = (ball_on_rod(0.005, (0.02, 0.1), 1.0), None)
ROWS["ball on a rod, aluminium"] = (ball_on_rod(0.01, (0.01, 0.2), 0.3, ("steel", "aluminium")), None)
ROWS["ball on a rod, 8 elements across"] = (ROWS["ball on a rod, 0.5 m/s"][0] + "interval = { elements = 8 }\n", None)
ROWS["ball on a rod, 4 modes"] = (ROWS["ball on a rod, 0.5 m/s"][0] + "[bodies.b.reduction]\nmodes = 4\n", None)
ROWS["ball on a rod, soft springs"] = (
    ROWS["ball on a rod, 0.5 m/s"][0] + 'penalty = { initial = 2e15, search = "fixed" }\n', None)
ROWS["two balls"] = (balls((0.01, 0.01), 0.2), None)
ROWS["small ball on a large one"] = (balls((0.005, 0.03), 1.0), None)
ROWS["ball of steel on aluminium"] = (balls((0.01, 0.015), 0.5, ("steel", "aluminium")), None)
ROWS["disc on a plane"] = (disc_on_plane(0.01, 0.1), None)
ROWS["disc on a plane, fast"] = (disc_on_plane(0.02, 1.0), None)
ROWS["two discs"] = (discs((0.01, 0.02), 0.5), None)
ROWS["two equal discs, plane stress"] = (discs((0.01, 0.01), 0.2, "plane-stress"), None)
for radius, lengths, speed in ((0.005, (0.1, 0.3), 2.0), (0.001, (0.2, 0.2), 1.0), (0.002, (0.1, 0.2), 0.5), (0.005, (0.1, 0.5), 1.0)):
    truth = truth_of_bars(radius, lengths, speed)
    ROWS[f"bars {lengths[0]} and {lengths[1]} m, radius {radius} m"] = (bars(radius, lengths, speed), truth)
ROWS["bars 0.1 and 0.3 m, 8 modes"] = (bars(0.005, (0.1, 0.3), 2.0, 8), truth_of_bars(0.005, (0.1, 0.3), 2.0))
ROWS["square on its face, plane strain"] = (block("plane-strain", 0.01, 0.1, (0, 1, 0)), None)
# Explicit elements written for the purpose.
ROWS["cube on its face"] = (block("solid", 0.01, 0.1, (0, 0, 1)), {"impulse": 1.398e-3})


def struck_beam(*held, at=0.05):
    """A disc falls on a beam along x in the plane, from -0.1 to 0.1 m, at `at`, where joints hold the beam."""
    return scenario(
        2e-4,
        body("a", "plane-stress", 'shape = "disc", radius = 0.01', (at, 0.015, 0), (0, -0.5, 0)),
        body("b", "plane-stress", 'shape = "rectangle", size = [0.2, 0.01]'),
        materials="".join(held),
    )


def joint(kind, at, child, more=""):
    parent = f'parent = {{ body = "ground", point = {list(map(float, at))} }}'
    return f'[joints.{kind}]\ntype = "{kind}"\n{parent}\nchild = {{ body = "b", {child} }}\n{more}'


Z = "axis = [0.0, 0.0, 1.0]\n"
LEFT = 'face = "x-"'
ROWS["ball on a rod on a spring"] = (
    ROWS["ball on a rod, 0.5 m/s"][0] + joint("axial", (0, 0, 0.3), 'marker = "end"', "stiffness = 1e6\n"), None)
ROWS["ball on a rod that is held"] = (
    ball_on_rod(0.01, (0.01, 0.1), 0.5) + joint("fixed", (0, 0, 0.1), 'marker = "end"'), None)
ROWS["disc on a cantilever"] = (struck_beam(joint("fixed", (-0.1, 0, 0), LEFT)), None)
ROWS["disc on a beam on a hinge"] = (struck_beam(joint("revolute", (-0.1, 0, 0), LEFT, Z)), None)
ROWS["disc on a beam on pin and roller"] = (
    struck_beam(
        joint("revolute", (-0.1, 0, 0), LEFT, Z),
        joint("generic", (0.1, 0, 0), 'face = "x+"', 'locked = ["y"]\ncloses_loop = true\n'),
    ), None)
ROWS["disc on a disc on a hinge"] = (
    scenario(
        1.5e-4,
        body("a", "plane-stress", 'shape = "disc", radius = 0.01', (-0.01, 0, 0), (0.5, 0, 0)),
        body("b", "plane-stress", 'shape = "disc", radius = 0.015'),
        materials=joint("revolute", (0.015, 0, 0), "point = [0.0, 0.0], radius = 0.004", Z),
    ), None)
HOLLOW = """[materials.celluloid]
youngs_modulus = 3e9
poissons_ratio = 0.35
density = 1400.0
[bodies.a]
model = "axisymmetric"
material = "celluloid"
position = [0.0, 0.0, 0.02]
velocity = [0.0, 0.0, -0.5]
[bodies.a.geometry]
shape = "nurbs"
degrees = [2, 1]
knots = [[0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]]
control_points = [[0.0, -0.02], [0.02, -0.02], [0.02, 0.0], [0.02, 0.02], [0.0, 0.02], [0.0, -0.0196], [0.0196, -0.0196], [0.0196, 0.0], [0.0196, 0.0196], [0.0, 0.0196]]
weights = [1.0, 0.7071067811865476, 1.0, 0.7071067811865476, 1.0, 1.0, 0.7071067811865476, 1.0, 0.7071067811865476, 1.0]
"""
# Axisymmetric elements written for the purpose.
ROWS["hollow ball, table tennis"] = (scenario(1.1e-3, HOLLOW, plane()), {"peak_force": 6.70, "impulse": 2.7566e-3})



def with_spin(text, spin, friction):
    """The scenario with its body a spinning [rad/s] and the coefficient of friction of its contact."""
    turning = f"[bodies.a]\nangular_velocity = [0.0, 0.0, {spin!r}]\n"
    return text.replace("[bodies.a]\n", turning, 1) + f"friction = {friction!r}\n"


def disc_of_triangles(radius, rings):
    """A disc [mm] of triangles with six nodes as an input file: six triangles about the middle, each cut into rings."""
    numbers, nodes, elements = {}, [], []

    def node(ring, along):
        key = (ring, along % (6 * ring) if ring else 0)
        if key not in numbers:
            numbers[key] = len(numbers) + 1
            angle, at = (along / max(ring, 1) - 1.5) * math.pi / 3, radius * ring / (2 * rings)
            nodes.append(f"{numbers[key]}, {at * math.cos(angle)!r}, {at * math.sin(angle)!r}\n")
        return numbers[key]

    def triangle(sector, corners):
        middles = [tuple((corners[a][d] + corners[b][d]) // 2 for d in (0, 1)) for a, b in ((0, 1), (1, 2), (2, 0))]
        places = [node(ring, sector * ring + along) for ring, along in [*corners, *middles]]
        elements.append(f"{len(elements) + 1}, " + ", ".join(map(str, places)) + "\n")

    for sector in range(6):
        for ring in range(rings):
            i, o = 2 * ring, 2 * ring + 2
            for k in range(0, i + 2, 2):
                triangle(sector, [(i, k), (o, k), (o, k + 2)])
                if k < i:
                    triangle(sector, [(i, k), (o, k + 2), (i, k + 2)])
    return "*NODE\n" + "".join(nodes) + "*ELEMENT, TYPE=CPE6, ELSET=disc\n" + "".join(elements)


def add_random(rows, seed):
    """Impacts drawn by chance: kinds of bodies and touches in turn, sizes, speeds and materials."""
    draw = random.Random(seed)
    first = 100 * SEEDS.index(seed)

    def between(low, high):
        return float(f"{low * (high / low) ** draw.random():.3g}")

    materials = ("steel", "aluminium", "brass")
    for n in range(1, 11):
        radius, speed, material = between(3e-3, 3e-2), between(0.02, 2.0), draw.choice(materials)
        rows[f"drawn: ball on a plane {first + n}"] = (ball_on_plane(radius, speed, material), None)
    for n in range(1, 11):
        radius, pair = between(4e-3, 2e-2), (draw.choice(materials), draw.choice(materials))
        rod = (radius * between(0.7, 2.0), radius * between(5.0, 30.0))
        text = ball_on_rod(radius, rod, between(0.05, 1.5), pair)
        rows[f"drawn: ball on a rod {first + n}"] = (text + END_OF_ROD, None)
    for n in range(1, 11):
        radius, pair = between(4e-3, 2e-2), (draw.choice(materials), draw.choice(materials))
        rows[f"drawn: two balls {first + n}"] = (balls((radius, radius * between(0.7, 4.0)), between(0.05, 1.5), pair), None)
    for n in range(1, 7):
        rows[f"drawn: disc on a plane {first + n}"] = (disc_on_plane(between(5e-3, 3e-2), between(0.05, 0.5)), None)
    for n in range(1, 9):
        radius = between(5e-3, 2e-2)
        model = draw.choice(("plane-strain", "plane-stress"))
        rows[f"drawn: two discs {first + n}"] = (discs((radius, radius * between(0.7, 2.0)), between(0.05, 0.5), model), None)
    for n in range(1, 9):
        radius, speed = between(5e-3, 2e-2), between(0.05, 0.3)
        text = with_spin(disc_on_plane(radius, speed), draw.choice((-1, 1)) * speed / radius * between(0.1, 3.0), between(0.05, 0.5))
        rows[f"drawn: spinning disc on a plane with friction {first + n}"] = (text, None)
    for n in range(1, 7):
        radius, speed = between(5e-3, 2e-2), between(0.05, 0.3)
        text = discs((radius, radius * between(0.7, 2.0)), speed, "plane-strain")
        text = with_spin(text, draw.choice((-1, 1)) * speed / radius * between(0.1, 3.0), between(0.05, 0.5))
        rows[f"drawn: two discs with spin and friction {first + n}"] = (text, None)
    holds = {
        "cantilever": [joint("fixed", (-0.1, 0, 0), LEFT)],
        "hinge": [joint("revolute", (-0.1, 0, 0), LEFT, Z)],
        "pin and roller": [
            joint("revolute", (-0.1, 0, 0), LEFT, Z),
            joint("generic", (0.1, 0, 0), 'face = "x+"', 'locked = ["y"]\ncloses_loop = true\n'),
        ],
        "nothing": [],
    }
    for n in range(1, 9):
        held = draw.choice(list(holds))
        rows[f"drawn: disc on a beam {first + n}, {held}"] = (
            struck_beam(*holds[held], at=round(draw.uniform(-0.08, 0.08), 4)) + PLACES_OF_BEAM, None)
    for n in range(1, 7):
        radius, rings, speed = between(5e-3, 2e-2), draw.randrange(10, 25), between(0.05, 0.3)
        text = disc_on_plane(radius, speed)
        shape = f'geometry = {{ shape = "disc", radius = {radius} }}\n'
        meshed = text.replace(shape, f'file = "drawn{first + n}.inp"\nunits = "mm"\n')
        FILES[f"drawn{first + n}.inp"] = disc_of_triangles(1e3 * radius, rings)
        rows[f"drawn: disc of triangles on a plane {first + n}"] = (meshed, text)
    for n in range(1, 3):
        radius, speed = between(5e-3, 2e-2), between(0.05, 0.5)
        ball = body("a", "solid", f'shape = "sphere", radius = {radius}', (0, 0, radius), (0, 0, -speed))
        rows[f"drawn: solid ball on a plane {first + n}"] = (scenario(6e-2 * radius * speed**-0.2, ball, plane()), ball_on_plane(radius, speed))


END_OF_ROD = '[output]\nfree_interval = 5e-7\n[output.points.end]\nbody = "b"\nmarker = "end"\n'
PLACES_OF_BEAM = """[output]
free_interval = 1e-6
[output.points]
tip = { body = "b", point = [0.1, 0.005] }
middle = { body = "b", point = [-0.02, -0.005], stress = true }
"""
FILES = {}
for SEED in SEEDS:
    add_random(ROWS, SEED)


def impact(program, text, path):
    """First impact of the run of `text`; None if it failed."""
    if not (path.with_suffix(".h5").exists() and path.exists() and path.read_text() == text):
        path.write_text(text)
        call = [program, "run", "-qq", "--force", str(path), "-o", str(path.with_suffix(".h5"))]
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"  {path.name}: exit code {done.returncode}: {done.stderr.strip()[:200]}", flush=True)
            return None
    with h5py.File(path.with_suffix(".h5")) as file:
        if len(file["impacts"]) == 0:
            return None
        row = file["impacts"][0]
        numbers = {name: float(row[name]) for name in row.dtype.names if row.dtype[name].kind == "f"}
        numbers["note"] = row["uncertainty"].decode()
        for series, group in PEAKS.items():
            for place in [place for place in file.get(group, {}) if series in file[group][place]]:
                found = file[group][place][series].attrs
                numbers[f"{series} of {place}"] = float(found["peak"])
                numbers[f"{series} of {place}_uncertainty"] = float(found.get("peak_uncertainty", math.nan))
        for name, body in file["bodies"].items():
            bands = body.get("eigenfrequencies_uncertainty", [])
            for k, band in enumerate(bands[:]):
                numbers[f"frequency of {name} {k + 1}"] = float(body["eigenfrequencies"][k])
                numbers[f"frequency of {name} {k + 1}_uncertainty"] = float(band)
    numbers["duration"] = numbers["end"] - numbers["start"]
    numbers["peak_time"] -= numbers["start"]
    return numbers


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--folder", default="target/uncertainty", type=pathlib.Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--table", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for name, text in FILES.items():
        (arguments.folder / name).write_text(text)
    found = []
    for number, (name, (text, truth)) in enumerate(ROWS.items()):
        if arguments.only not in name:
            continue
        if "[joints" in text or "[output.points" in text:
            text = text.replace(STOP, "")  # largest values are those up to one time
        path = arguments.folder / f"row{number:03}.toml"
        run = impact(arguments.program, text, path)
        if run is not None and (truth is None or isinstance(truth, str)):
            truth = impact(arguments.program, FINER + without_own(truth or text), path.with_name(f"row{number:03}_truth.toml"))
        if run is None or truth is None:
            continue
        rows = compared(name, run, truth)
        found += rows
        told = [f"{row.output} {row.error:.1e} ({row.band:.1e}){'' if row.is_within else ' OUT'}" for row in rows]
        print(f"{name}: " + ", ".join(told), run["note"][:60], flush=True)
    lines = tables(found)
    print("\n".join(lines))
    if arguments.table:
        arguments.table.write_text("\n".join(lines) + "\n")


class Row(NamedTuple):
    """A number of an impact beside the truth: error and band as shares of the truth."""

    name: str
    output: str
    error: float
    band: float

    @property
    def is_within(self):
        return self.error <= self.band


def compared(name, run, truth):
    """The numbers of `run` that have a band and a truth, but for what is round-off of a zero."""
    rows = []
    peaks = [key for key in run if " of " in key and not key.endswith("_uncertainty")]
    for output in [*OUTPUTS, *peaks]:
        band, value, right = run[f"{output}_uncertainty"], run[output], truth.get(output, math.nan)
        if all(map(math.isfinite, (band, value, right))) and abs(right) > 1e-12:
            rows.append(Row(name, output, abs(value - right) / abs(right), band / abs(right)))
    return rows


def tables(found):
    """How often bands are right, and which are not."""
    lines = ["| number | within | band over error, median | band, median |", "|---|---|---|---|"]
    outputs = {row.output.split(" of ")[0]: None for row in found}
    for output in outputs:
        rows = [row for row in found if row.output.split(" of ")[0] == output]
        within = sum(row.is_within for row in rows)
        ratio = np.median([row.band / max(row.error, 1e-12) for row in rows])
        words = output.replace("_", " ").replace("position", "displacement")
        share, band = 100 * within / len(rows), np.median([row.band for row in rows])
        lines.append(f"| {words} | {within} of {len(rows)}, {share:.0f} % | {ratio:.1f} | {band:.1e} |")
    lines += ["", "| kind | impacts | bands | within |", "|---|---|---|---|"]
    kind = lambda row: "at which constants were settled" if not row.name.startswith("drawn: ") else re.sub(r" \d+.*", "", row.name)
    for name in {kind(row): None for row in found}:
        rows = [row for row in found if kind(row) == name]
        impacts = len({row.name for row in rows})
        lines.append(f"| {name} | {impacts} | {len(rows)} | {sum(row.is_within for row in rows)} |")
    lines += ["", "| outside | number | error | band |", "|---|---|---|---|"]
    outside = [row for row in found if not row.is_within]
    lines += [f"| {row.name} | {row.output.replace('_', ' ')} | {row.error:.1e} | {row.band:.1e} |" for row in outside]
    return lines


def without_own(text):
    """The scenario without what coarsens it on purpose."""
    for coarse in ("interval = { elements = 8 }\n", 'penalty = { initial = 2e15, search = "fixed" }\n'):
        text = text.replace(coarse, "")
    return text.replace("[bodies.b.reduction]\nmodes = 4\n", "")


if __name__ == "__main__":
    main()
