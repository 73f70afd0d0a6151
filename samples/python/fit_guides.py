#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A flow that follows two rings in a closed ball: cage, fit, and a bake that cannot leak.

Usage: fit_guides.py [OUT.vdb]
"""
import sys

import numpy as np

import octetvdb


def ball(rings=24, segments=36):
    """A sphere as a closed surface of triangles."""
    a = np.pi * np.arange(1, rings) / rings
    b = 2 * np.pi * np.arange(segments) / segments
    middle = np.stack([np.outer(np.sin(a), np.cos(b)), np.outer(np.sin(a), np.sin(b)),
                       np.outer(np.cos(a), np.ones(segments))], axis=-1).reshape(-1, 3)
    vertices = np.vstack([[[0, 0, 1]], middle, [[0, 0, -1]]])
    here = 1 + np.arange(segments)
    there = 1 + (np.arange(segments) + 1) % segments
    top = np.stack([np.zeros(segments, int), here, there], axis=1)
    bottom = np.stack([here + (rings - 2) * segments, np.full(segments, len(vertices) - 1),
                       there + (rings - 2) * segments], axis=1)
    bands = [np.stack([here, here + segments, there + segments, here, there + segments, there],
                      axis=1).reshape(-1, 3) + k * segments for k in range(rings - 2)]
    return vertices, np.concatenate([top, *bands, bottom])


def ring(radius, z):
    angles = np.linspace(0, 2 * np.pi, 65)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(65, z)], axis=1)


def main(path):
    vertices, triangles = ball()
    mesh = octetvdb.fill_surface(vertices, triangles, 0.25, fit_boundary=True)
    print(mesh)
    guides = [octetvdb.GuideCurve("lower ring", ring(0.6, -0.35), 1.0),
              octetvdb.GuideCurve("upper ring", ring(0.6, 0.35)[::-1], 1.0)]
    result = octetvdb.Fit(mesh).solve(guides)
    for guide in result.report.guides:
        print(f"{guide.name}: {100 * guide.residual:.2f} % off")
    outward = result.flux[mesh.complex.boundary_facets]
    print(f"flux through the walls: {np.abs(outward).max():.1e}")

    asset = octetvdb.ControlAsset(mesh, [octetvdb.Form(mesh, "velocity", 2, result.flux)],
                                  name="rings")
    report = octetvdb.bake(asset, path, resolution=48, boundary=result.boundary)
    print(f"{path}: up to {report.files[0].grids[0].max:.3f}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "rings.vdb")
