#!/usr/bin/env python3
"""Write a plane Bernoulli beam as a body file (docs/body-file.md): an example for other finite element programs.

Needs numpy and h5py. Usage: beam_body_file.py beam.h5
"""

import sys

import h5py
import numpy as np

LENGTH = 2.0  # m
N_ELEMENTS = 20
YOUNG, DENSITY = 2.1e11, 7850.0  # Pa, kg/m^3
WIDTH, HEIGHT = 0.01, 0.01  # m


def element(h):
    """Stiffness and consistent mass of one element; unknowns u_x, u_y, rotation about z of both ends."""
    area, inertia = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
    k, m = np.zeros((6, 6)), np.zeros((6, 6))
    along, across = [0, 3], [1, 2, 4, 5]
    k[np.ix_(along, along)] = YOUNG * area / h * np.array([[1, -1], [-1, 1]])
    m[np.ix_(along, along)] = DENSITY * area * h / 6 * np.array([[2, 1], [1, 2]])
    k[np.ix_(across, across)] = YOUNG * inertia / h**3 * np.array(
        [[12, 6 * h, -12, 6 * h],
         [6 * h, 4 * h**2, -6 * h, 2 * h**2],
         [-12, -6 * h, 12, -6 * h],
         [6 * h, 2 * h**2, -6 * h, 4 * h**2]])
    m[np.ix_(across, across)] = DENSITY * area * h / 420 * np.array(
        [[156, 22 * h, 54, -13 * h],
         [22 * h, 4 * h**2, 13 * h, -3 * h**2],
         [54, 13 * h, 156, -22 * h],
         [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])
    return k, m


def write_matrix(file, name, matrix, **attributes):
    """Store a symmetric matrix as coordinate triplets."""
    group = file.create_group(name)
    rows, columns = np.nonzero(matrix)
    group["rows"], group["columns"], group["values"] = rows, columns, matrix[rows, columns]
    group.attrs["layout"], group.attrs["triangle"] = "coo", "full"
    group.attrs.update(attributes)


def main(path):
    """Assemble the beam and write it."""
    n_nodes = N_ELEMENTS + 1
    stiffness, mass = np.zeros((3 * n_nodes, 3 * n_nodes)), np.zeros((3 * n_nodes, 3 * n_nodes))
    k, m = element(LENGTH / N_ELEMENTS)
    for e in range(N_ELEMENTS):
        unknowns = slice(3 * e, 3 * e + 6)
        stiffness[unknowns, unknowns] += k
        mass[unknowns, unknowns] += m
    nodes = np.zeros((n_nodes, 3))
    nodes[:, 0] = np.linspace(0, LENGTH, n_nodes)
    with h5py.File(path, "w") as file:
        file.attrs.update(format="fbimpact-body", format_version=1, kind="full", model="plane", name="beam")
        file["nodes"] = nodes
        file["dofs"] = np.array([(node, component) for node in range(n_nodes) for component in range(3)])
        write_matrix(file, "stiffness", stiffness)
        write_matrix(file, "mass", mass, rows_are="unknowns")
        for name, node in (("hinge", 0), ("tip", N_ELEMENTS)):
            marker = file.create_group(f"markers/{name}")
            marker["position"], marker["nodes"] = nodes[node], np.array([node])


if __name__ == "__main__":
    main(sys.argv[1])
