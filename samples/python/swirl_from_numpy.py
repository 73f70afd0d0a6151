#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An incompressible swirl from nothing but numpy: a cage, circulations of a vector potential, and the
velocity as their derivative, baked for Blender.

Usage: swirl_from_numpy.py [OUT.vdb]
"""
import itertools
import sys

import numpy as np

import octetvdb


def box_cage(cells, size):
    """Cubes of six tetrahedra each. The box' sharp edges are found, so it stays a box."""
    n = np.array(cells)
    grid = np.stack(np.meshgrid(*(np.arange(m + 1) for m in n), indexing="ij"), axis=-1)
    vertices = (grid / n - 0.5) * size
    corner = np.stack(np.meshgrid(*(np.arange(m) for m in n), indexing="ij"), axis=-1)
    tetrahedra = []
    for axes in itertools.permutations(range(3)):
        steps = np.cumsum([np.zeros(3, int)] + [np.eye(3, dtype=int)[a] for a in axes], axis=0)
        path = corner.reshape(-1, 1, 3) + steps
        tetrahedra.append(np.ravel_multi_index(tuple(np.moveaxis(path, -1, 0)), n + 1))
    return octetvdb.ControlMesh(vertices.reshape(-1, 3), np.concatenate(tetrahedra))


def potential(points):
    """A vector potential that is normal to the walls of the box -1 < x, y, z < 1, so no flow passes
    them: A = (0, 0, cos(pi x / 2) cos(pi y / 2))."""
    x, y, z = np.moveaxis(points, -1, 0)
    height = np.cos(np.pi * x / 2) * np.cos(np.pi * y / 2)
    return np.stack([np.zeros_like(x), np.zeros_like(y), height], axis=-1)


def circulations(mesh, field):
    """Integrals of a vector field along all edges, by Gauss quadrature."""
    a, b = (mesh.vertices[mesh.complex.edges[:, k]] for k in range(2))
    nodes, weights = np.polynomial.legendre.leggauss(5)
    total = 0
    for t, w in zip((nodes + 1) / 2, weights / 2):
        total = total + w * np.einsum("ij,ij->i", field(a + t * (b - a)), b - a)
    return total


def main(path):
    mesh = box_cage((10, 10, 10), 2.0)
    w = circulations(mesh, potential)
    velocity = mesh.complex.derivative(1, w)
    # What should be 0 at the walls is 0 but for rounding; then it stays exactly 0.
    velocity[np.abs(velocity) < 1e-14] = 0
    print(f"{mesh}")
    print(f"divergence of the control cells: {np.abs(mesh.complex.derivative(2, velocity)).max():.1e}")
    asset = octetvdb.ControlAsset(mesh, [octetvdb.Form(mesh, "velocity", 2, velocity, unit="m/s")],
                                  name="swirl")

    refiner = octetvdb.Refiner(mesh, levels=2)
    points = np.random.default_rng(0).uniform(-0.9, 0.9, (1000, 3))
    values, inside = refiner.field(2, velocity).sample(points)
    x, y, z = points.T
    exact = np.pi / 2 * np.stack([-np.cos(np.pi * x / 2) * np.sin(np.pi * y / 2),
                                  np.sin(np.pi * x / 2) * np.cos(np.pi * y / 2), 0 * z], axis=-1)
    error = np.linalg.norm(values - exact, axis=1) / np.linalg.norm(exact, axis=1).max()
    print(f"inside: {inside.all()}, error {100 * np.sqrt(np.mean(error**2)):.2f} % (RMS)")

    report = octetvdb.bake(asset, path, resolution=64, target="blender")
    grid = report.files[0].grids[0]
    print(f"{path}: {grid.name}, {grid.active_voxels} voxels, up to {grid.max:.3f}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "swirl.vdb")
