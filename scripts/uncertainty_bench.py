#!/usr/bin/env python3
"""How often the truth lies within the bands of impacts, and how wide these are (docs/uncertainty.md).

    uncertainty_bench.py PROGRAM [--folder DIR] [--only TEXT] [--table FILE]

Every row is an impact: its numbers with their bands by the defaults, and the truth, a closed form or the same scenario with
`accuracy = "fine"` and, by `[resolution]`, twice the modes, elements and points across, stiffer springs and a tenth of the tolerance. A
truth by refinement has an error of its own, which is not known: small errors and their ratios to bands are no sharper than that.
Needs h5py and numpy. Runs that are there already in DIR are not made again.
"""
import argparse
import json
import math
import pathlib
import subprocess

import h5py
import numpy as np

STEEL = dict(E=210e9, nu=0.3, rho=7850.0)
OUTPUTS = ["peak_force", "duration", "impulse", "separation_velocity", "restitution"]
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
    return f"[simulation]\nend_time = {time!r}\nstop_after_impacts = 1\n{materials}" + "".join(bodies) + law


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
    numbers["duration"] = numbers["end"] - numbers["start"]
    return numbers


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--folder", default="target/uncertainty", type=pathlib.Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--table", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    cells, lines = {name: [] for name in OUTPUTS}, []
    for number, (name, (text, truth)) in enumerate(ROWS.items()):
        if arguments.only not in name:
            continue
        path = arguments.folder / f"row{number:03}.toml"
        found = impact(arguments.program, text, path)
        if found is None:
            continue
        if truth is None:
            finer = FINER + without_own(text)
            truth = impact(arguments.program, finer, path.with_name(f"row{number:03}_truth.toml"))
        if truth is None:
            continue
        told = []
        for output in OUTPUTS:
            band, value = found[f"{output}_uncertainty"], found[output]
            if output not in truth or not math.isfinite(truth[output]) or not math.isfinite(value):
                told.append("")
                continue
            error = abs(value - truth[output])
            if not math.isfinite(band):
                told.append("–")
                continue
            cells[output].append((error <= band, band / max(error, 1e-12 * abs(value)), name))
            told.append(f"{error / abs(truth[output]):.1e} ({band / abs(truth[output]):.1e})" + ("" if error <= band else " out"))
        lines.append(f"| {name} | " + " | ".join(told) + " |")
        print(lines[-1], found["note"][:60], flush=True)
    print()
    lines.append("")
    for output, rows in cells.items():
        if rows:
            share = sum(row[0] for row in rows) / len(rows)
            ratio = float(np.median([row[1] for row in rows]))
            lines.append(f"{output}: {100 * share:.0f} % of {len(rows)} within, band over error {ratio:.1f} in the median")
            print(lines[-1])
    if arguments.table:
        arguments.table.write_text("\n".join(lines) + "\n")


def without_own(text):
    """The scenario without what coarsens it on purpose."""
    for coarse in ("interval = { elements = 8 }\n", 'penalty = { initial = 2e15, search = "fixed" }\n'):
        text = text.replace(coarse, "")
    return text.replace("[bodies.b.reduction]\nmodes = 4\n", "")


if __name__ == "__main__":
    main()
