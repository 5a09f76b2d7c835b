#!/usr/bin/env python3
"""Mesh a disc with Gmsh, once for each kind of element and form of the file that the readers are tested with.

Usage: mesh_gmsh.py [FOLDER]; needs Gmsh's Python module (pip install gmsh). A cylinder of radius 5 and height 3 mm with the groups
"disc", "bottom", "top" and "jacket". Pyramids stand between a layer of hexahedra and tetrahedra above it.
"""

import pathlib
import sys

import gmsh

ROOT = pathlib.Path(__file__).resolve().parent.parent
# name: elements, order, without middles of sides, version, binary
FILES = {
    "tet10_text41": ("tet", 2, 0, 4.1, 0),
    "tet10_binary41": ("tet", 2, 0, 4.1, 1),
    "tet4_text22": ("tet", 1, 0, 2.2, 0),
    "hex20_text22": ("hex", 2, 1, 2.2, 0),
    "hex27_binary41": ("hex", 2, 0, 4.1, 1),
    "hex20_binary22": ("hex", 2, 1, 2.2, 1),
    "wedge15_binary22": ("wedge", 2, 1, 2.2, 1),
    "wedge18_text41": ("wedge", 2, 0, 4.1, 0),
    "pyramid5_binary41": ("pyramid", 1, 0, 4.1, 1),
    "pyramid13_binary22": ("pyramid", 2, 1, 2.2, 1),
    "pyramid14_text41": ("pyramid", 2, 0, 4.1, 0),
}


def mesh(path, kind, order, incomplete, version, binary):
    gmsh.model.add("disc")
    geo = gmsh.model.occ
    disc = geo.addDisk(0, 0, 0, 5, 5)
    layers, height = {"tet": ([], 3), "pyramid": ([1], 1.2)}.get(kind, ([2], 3))
    parts = [geo.extrude([(2, disc)], 0, 0, height, numElements=layers, recombine=kind != "tet")]
    if kind == "pyramid":
        parts.append(geo.extrude([parts[0][0]], 0, 0, 3 - height))
    geo.synchronize()
    jacket = [t for part in parts for d, t in part[2:] if d == 2]
    gmsh.model.addPhysicalGroup(3, [tag for part in parts for dim, tag in part if dim == 3], name="disc")
    for name, tags in (("bottom", [disc]), ("top", [parts[-1][0][1]]), ("jacket", jacket)):
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    if kind == "pyramid":
        gmsh.model.mesh.setRecombine(2, disc)
    option = gmsh.option.setNumber
    option("Mesh.MeshSizeMin", 4)
    option("Mesh.MeshSizeMax", 4)
    option("Mesh.RecombineAll", int(kind == "hex"))
    option("Mesh.RecombinationAlgorithm", 2)
    option("Mesh.SecondOrderIncomplete", incomplete)
    option("Mesh.MshFileVersion", version)
    option("Mesh.Binary", binary)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    gmsh.write(str(path))
    gmsh.model.remove()


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "crates/fe-mesh/tests/gmsh"
    folder.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    for name, settings in FILES.items():
        mesh(folder / f"{name}.msh", *settings)
    gmsh.finalize()


if __name__ == "__main__":
    main()
