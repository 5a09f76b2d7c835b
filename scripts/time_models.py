#!/usr/bin/env python3
"""Time a dozen typical impacts with nothing but geometry, material and motion given: what a user waits for, choosing included (docs/performance.md).

Usage: time_models.py [--fbimpact PROGRAM] [--only NAME]; prints a Markdown table. Nothing is kept between runs. Take a quiet machine.

The closed form beside a peak is Hertz' theory of two elastic balls, or of one on a rigid plane.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import tempfile

MATERIALS = {"steel": (210e9, 0.3, 7850.0), "aluminium": (70e9, 0.33, 2700.0)}
FLOOR = '[bodies.floor]\nmodel = "rigid"\ngeometry = { shape = "plane" }\n'


def body(name, model, material, geometry, position, velocity=0.0, more=""):
    """A body that moves along z, or along y if it is plane."""
    motion = [0.0, velocity, 0.0] if model.startswith("plane") else [0.0, 0.0, velocity]
    return (
        f'[bodies.{name}]\nmodel = "{model}"\nmaterial = "{material}"\ngeometry = {{ {geometry} }}\n'
        f"position = {position}\nvelocity = {motion}\n{more}\n"
    )


def scenario(end, *parts, contact, target):
    return f'[simulation]\nend_time = {end}\n{"".join(parts)}[contacts.c]\ncontact_body = "{contact}"\ntarget_body = "{target}"\n'


def hertz(radii, masses, speed, materials):
    """Largest force of two balls, or of one on a plane (infinite radius and mass)."""
    modulus = 1.0 / sum((1.0 - p * p) / e for e, p, _ in materials)
    radius, mass = (1.0 / sum(1.0 / x for x in xs) for xs in (radii, masses))
    stiffness = 4.0 / 3.0 * modulus * math.sqrt(radius)
    approach = (1.25 * mass * speed**2 / stiffness) ** 0.4
    return stiffness * approach**1.5


def ball_mass(radius, material):
    return 4.0 / 3.0 * math.pi * radius**3 * MATERIALS[material][2]


def models():
    """Name, scenario, peak in closed form if there is one."""
    steel, aluminium = MATERIALS["steel"], MATERIALS["aluminium"]
    ball = 'shape = "sphere", radius = 0.01'
    rigid = (math.inf, 0.0, 0.0)
    on_plane = hertz([0.01, math.inf], [ball_mass(0.01, "steel"), math.inf], 0.1, [steel, rigid])
    for model in ("axisymmetric", "solid"):
        yield (
            f"ball of 10 mm on a rigid plane, {model}",
            scenario(1.5e-4, body("ball", model, "steel", ball, [0, 0, 0.010001], -0.1), FLOOR, contact="ball", target="floor"),
            on_plane,
        )
    big = 'shape = "sphere", radius = 1.0'
    yield (
        "ball of 10 mm on one of 1 m, axisymmetric",
        scenario(1.5e-4, body("ball", "axisymmetric", "steel", ball, [0, 0, 0.010001], -0.1),
                 body("big", "axisymmetric", "steel", big, [0, 0, -1.0]), contact="ball", target="big"),
        hertz([0.01, 1.0], [ball_mass(0.01, "steel"), ball_mass(1.0, "steel")], 0.1, [steel, steel]),
    )  # fmt: skip
    yield (
        "balls of 8 mm (aluminium) and 5 mm (steel), solid",
        scenario(1.2e-4, body("a", "solid", "aluminium", 'shape = "sphere", radius = 0.008', [0, 0, 0.0080005], -0.3),
                 body("b", "solid", "steel", 'shape = "sphere", radius = 0.005', [0, 0, -0.005]), contact="b", target="a"),
        hertz([0.008, 0.005], [ball_mass(0.008, "aluminium"), ball_mass(0.005, "steel")], 0.3, [aluminium, steel]),
    )  # fmt: skip
    bar = 'shape = "cylinder", radius = 0.008, length = 0.1'
    yield (
        "bars of 16 x 100 mm end to end, axisymmetric",
        scenario(1.2e-4, body("a", "axisymmetric", "aluminium", bar, [0, 0, 1e-6], -1.0),
                 body("b", "axisymmetric", "aluminium", bar, [0, 0, -0.1]), contact="a", target="b"),
        None,
    )  # fmt: skip
    yield (
        "ring of 100 mm, 10 mm thick, falls flat, axisymmetric",
        scenario(3e-4, body("ring", "axisymmetric", "steel", 'shape = "torus", radius = 0.05, tube_radius = 0.005', [0, 0, 0.005001], -0.1),
                 FLOOR, contact="ring", target="floor"),
        None,
    )  # fmt: skip
    yield (
        "discs of 2 mm and 12 mm, plane strain",
        scenario(6e-5, body("a", "plane-strain", "aluminium", 'shape = "disc", radius = 0.002', [0, 0.002001, 0], -0.6, "thickness = 1.0"),
                 body("b", "plane-strain", "steel", 'shape = "disc", radius = 0.012', [0, -0.012, 0], 0.0, "thickness = 1.0"),
                 contact="a", target="b"),
        None,
    )  # fmt: skip
    yield (
        "ball of 5 mm, rigid, on a plate of 100 x 100 x 6 mm, solid",
        scenario(3e-4, body("plate", "solid", "aluminium", 'shape = "box", size = [0.1, 0.1, 0.006]', [0, 0, 0]),
                 body("ball", "rigid", "steel", 'shape = "sphere", radius = 0.005', [0, 0, 0.008001], -1.0), contact="plate", target="ball"),
        None,
    )  # fmt: skip
    box = 'shape = "box", size = [0.03, 0.02, 0.012]'
    for name, turn, height in (("face", "[0, 0, 0]", 0.006), ("edge", "[45, 0, 0]", 0.5 * math.sqrt(0.5) * 0.032)):
        yield (
            f"box of 30 x 20 x 12 mm on its {name}, solid",
            scenario(4e-4, body("box", "solid", "steel", box, [0, 0, height + 1e-6], -0.2, f"orientation_deg = {turn}"), FLOOR,
                     contact="box", target="floor"),
            None,
        )  # fmt: skip
    yield (
        "cylinder of 20 x 30 mm on its side, solid",
        scenario(1e-4, body("roller", "solid", "steel", 'shape = "cylinder", radius = 0.01, length = 0.03', [0, 0.015, 0.010001], -0.1,
                            "orientation_deg = [90, 0, 0]"), FLOOR, contact="roller", target="floor"),
        None,
    )  # fmt: skip


def run(program, text):
    """Result and resources of a run."""
    with tempfile.TemporaryDirectory() as folder:
        path, result, measured = (pathlib.Path(folder) / name for name in ("s.toml", "s.h5", "time"))
        path.write_text(text)
        environment = {**os.environ, "FBIMPACT_CACHE": "off"}
        command = ["/usr/bin/time", "-o", measured, "-f", "%e %U %S %M", program, "run", "-qq", path, "-o", result]
        subprocess.run(command, check=True, env=environment)
        wall, user, system, memory = map(float, measured.read_text().split()[-4:])
        found = subprocess.run([program, "info", "--json", result], check=True, capture_output=True, text=True)
    return json.loads(found.stdout), wall, user + system, memory / 1024.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fbimpact", default="target/release/fbimpact")
    parser.add_argument("--only", default="", help="part of a name")
    arguments = parser.parse_args()
    print("| model | modes | trials | wall | processor | choosing | memory | peak | closed form | warnings |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, text, exact in models():
        if arguments.only not in name:
            continue
        info, wall, processor, memory = run(arguments.fbimpact, text)
        modes = ", ".join(str(b["elastic_coordinates"]) for b in info["bodies"].values() if b.get("elastic_coordinates"))
        peak = max((i["peak_force"] for i in info["impacts"]), default=math.nan)
        close = f"{exact:.4g} N ({100 * (peak / exact - 1):+.1f} %)" if exact else ""
        warnings = ", ".join(sorted({w["identifier"] for w in info["warnings"]}))
        print(
            f"| {name} | {modes} | {len(info['tries'])} | {wall:.1f} s | {processor:.1f} s | {info['timings']['sizes']:.1f} s"
            f" | {memory:.0f} MiB | {peak:.4g} N | {close} | {warnings} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
