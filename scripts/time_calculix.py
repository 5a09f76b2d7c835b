#!/usr/bin/env python3
"""Time a meshed ball that hits a rigid plane: fbimpact against CalculiX' implicit dynamics with contact, on the same mesh (docs/performance.md).

Usage: time_calculix.py [FOLDER] [--fbimpact PROGRAM] [--step SECONDS]; needs ccx on the path and Gmsh's Python module (pip install gmsh).

A ball of steel of 10 mm, quadratic tetrahedra with two and more sides on the contact radius, falls at 10 m/s on a plane. CalculiX: direct steps of a
hundredth of the impact's duration (--step for others), contact from surface to surface with a linear pressure over overclosure of fifty Young's moduli per
millimetre, the plane a fixed brick. Both run on one thread; processor times are of the whole programs, reading and writing included.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import tempfile

import gmsh

RADIUS = 10.0  # mm
SPEED = 10.0  # m/s
YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0
HEIGHT = 1e-3  # mm over the plane
END = 4.0e-5  # s; the impact lasts some 33 us

SCENARIO = f"""[simulation]
end_time = {END}

[materials.steel]
youngs_modulus = {YOUNG}
poissons_ratio = {POISSON}
density = {DENSITY}

[bodies.ball]
model = "mesh"
file = "ball.msh"
units = "mm"
material = "steel"
position = [0.0, 0.0, {1e-3 * (RADIUS + HEIGHT)}]
velocity = [0.0, 0.0, {-SPEED}]

[bodies.floor]
model = "rigid"
geometry = {{ shape = "plane" }}

[contacts.impact]
contact_body = "ball"
target_body = "floor"
model = "quasistatic"
"""


def mesh(path, at_touch, elsewhere):
    """A ball in millimetres; nodes {tag: place}, tetrahedra {tag: nodes} in the order of Abaqus."""
    gmsh.initialize()
    option = gmsh.option.setNumber
    option("General.Verbosity", 1)
    ball = gmsh.model.occ.addSphere(0, 0, 0, RADIUS)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [ball], name="ball")
    field = gmsh.model.mesh.field
    field.add("Ball", 1)
    for name, value in (("ZCenter", -RADIUS), ("Radius", 1.6), ("VIn", at_touch), ("VOut", elsewhere), ("Thickness", 4.0)):
        field.setNumber(1, name, value)
    field.setAsBackgroundMesh(1)
    option("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(str(path))
    tags, places, _ = gmsh.model.mesh.getNodes()
    nodes = {int(t): places[3 * i : 3 * i + 3] for i, t in enumerate(tags)}
    elements, connected = gmsh.model.mesh.getElementsByType(11)
    order = (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)  # Gmsh has the last two edges the other way round
    tetrahedra = {int(e): [int(connected[10 * i + k]) for k in order] for i, e in enumerate(elements)}
    gmsh.finalize()
    used = {n for e in tetrahedra.values() for n in e}
    return {n: x for n, x in nodes.items() if n in used}, tetrahedra


def deck(nodes, tetrahedra, step):
    """The input file of CalculiX in N, mm, t, s."""
    sides = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))  # S1 to S4
    owners = {}
    for e, corners in tetrahedra.items():
        for s, side in enumerate(sides):
            owners.setdefault(frozenset(corners[k] for k in side), []).append((e, s + 1, [corners[k] for k in side]))
    low = -RADIUS + 2.5
    touched = [
        (e, s) for all in owners.values() if len(all) == 1 for e, s, own in all if max(nodes[n][2] for n in own) < low
    ]
    lines = ["*NODE, NSET=BALL"]
    lines += [f"{n}, {x:.9e}, {y:.9e}, {z + RADIUS + HEIGHT:.9e}" for n, (x, y, z) in sorted(nodes.items())]
    first = max(nodes) + 1
    corners = [(x, y, z) for z in (-1.0, 0.0) for x, y in ((-8, -8), (8, -8), (8, 8), (-8, 8))]
    lines.append("*NODE, NSET=FLOOR")
    lines += [f"{first + i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(corners)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=BALL")
    lines += [", ".join(map(str, [e, *own])) for e, own in sorted(tetrahedra.items())]
    brick = max(tetrahedra) + 1
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=FLOOR", ", ".join(map(str, [brick, *range(first, first + 8)]))]
    lines += ["*SURFACE, NAME=TOUCHED"] + [f"{e}, S{s}" for e, s in touched]
    lines += ["*SURFACE, NAME=PLANE", f"{brick}, S2", "*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG * 1e-6}, {POISSON}"]
    lines += ["*DENSITY", f"{DENSITY * 1e-12}", "*SOLID SECTION, ELSET=BALL, MATERIAL=STEEL"]
    lines += ["*SOLID SECTION, ELSET=FLOOR, MATERIAL=STEEL", "*SURFACE INTERACTION, NAME=TOUCH"]
    lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{50 * YOUNG * 1e-6}"]
    lines += ["*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE", "TOUCHED, PLANE"]
    lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY", f"BALL, 3, {-1e3 * SPEED}", "*BOUNDARY", "FLOOR, 1, 3"]
    lines += ["*STEP, NLGEOM, INC=100000", "*DYNAMIC, DIRECT", f"{step}, {END}"]
    lines += ["*NODE PRINT, NSET=FLOOR, TOTALS=ONLY", "RF", "*END STEP", ""]
    return "\n".join(lines)


def timed(command, folder):
    """Processor and wall time of a command [s], on one thread."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1", "FBIMPACT_CACHE": "off"}
    begin = os.times()
    with open(folder / "log.txt", "a", encoding="utf-8") as log:
        subprocess.run(command, cwd=folder, env=environment, check=True, stdout=log, stderr=log)
    end = os.times()
    processor = end.children_user + end.children_system - begin.children_user - begin.children_system
    return processor, end.elapsed - begin.elapsed


def reactions(path):
    """Times and total forces on the plane that CalculiX prints [s], [N]."""
    history, time = [], None
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if "time" in words:
            time = float(words[-1])
        elif len(words) == 3 and time is not None:
            try:
                history.append((time, abs(float(words[2]))))
            except ValueError:
                continue
    return history


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--fbimpact", default="fbimpact")
    parser.add_argument("--step", type=float, default=0.33e-6)
    parser.add_argument("--sizes", type=float, nargs=2, default=(0.45, 3.5), help="of elements, at the touch and elsewhere [mm]")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    nodes, tetrahedra = mesh(folder / "ball.msh", *arguments.sizes)
    (folder / "ball.toml").write_text(SCENARIO, encoding="utf-8")
    (folder / "ball_ccx.inp").write_text(deck(nodes, tetrahedra, arguments.step), encoding="utf-8")
    print(f"{folder}: {len(nodes)} nodes, {len(tetrahedra)} tetrahedra")
    program = shutil.which(arguments.fbimpact) or arguments.fbimpact
    own = timed([program, "run", "-q", "--threads", "1", "ball.toml", "-o", "ball.h5"], folder)
    found = subprocess.run([program, "info", "ball.h5"], cwd=folder, check=True, capture_output=True, text=True).stdout
    impact = next(line for line in found.splitlines() if line.split()[1:2] == ["impact"]).split()
    print(f"fbimpact: {own[0]:.1f} s of a processor, {own[1]:.1f} s; {impact[4]} N, {impact[3]} s", flush=True)
    other = timed(["ccx", "ball_ccx"], folder)
    history = reactions(folder / "ball_ccx.dat")
    closed = [time for time, force in history if force > 0.0]
    peak = max(force for _, force in history)
    print(f"CalculiX: {other[0]:.1f} s of a processor, {other[1]:.1f} s; {peak:.2f} N, {max(closed) - min(closed):.3e} s")
    print(f"ratio of processor times: {other[0] / own[0]:.0f}")


if __name__ == "__main__":
    main()
