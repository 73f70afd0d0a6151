#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the level set of something like a bunny, ellipsoids blended into each other, to a .vdb.
Usage: bunny.py OUT.vdb. Needs NumPy and pyopenvdb."""
import sys

import numpy as np
import pyopenvdb as vdb

VOXEL = 0.02
# Centre, half axes, and the lean of the long axis towards +x.
PARTS = (
    ((0.0, 0.0, 0.55), (0.62, 0.48, 0.55), 0.0),   # body
    ((0.55, 0.0, 1.15), (0.36, 0.30, 0.32), 0.0),  # head
    ((0.42, 0.15, 1.66), (0.11, 0.13, 0.42), -0.25),  # ears
    ((0.42, -0.15, 1.66), (0.11, 0.13, 0.42), -0.25),
    ((-0.66, 0.0, 0.42), (0.18, 0.18, 0.18), 0.0),  # tail
    ((0.42, 0.27, 0.14), (0.30, 0.16, 0.15), 0.0),  # paws
    ((0.42, -0.27, 0.14), (0.30, 0.16, 0.15), 0.0),
)
BLEND = 0.06


def distance(p):
    """About the signed distance: of each ellipsoid to first order, blended by a soft minimum."""
    total = 0.0
    for centre, axes, lean in PARTS:
        q = p - np.array(centre)
        q = np.stack((q[..., 0] - lean * q[..., 2], q[..., 1], q[..., 2]), axis=-1)
        scaled = q / np.array(axes)
        length = np.linalg.norm(scaled, axis=-1)
        slope = np.linalg.norm(scaled / np.array(axes), axis=-1)
        total = total + np.exp(-(length * (length - 1) / np.maximum(slope, 1e-9)) / BLEND)
    return -BLEND * np.log(np.maximum(total, 1e-30))


def main(path):
    low, high = np.array([-1.0, -0.7, -0.2]), np.array([1.1, 0.7, 2.3])
    counts = np.ceil((high - low) / VOXEL).astype(int)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
    band = 3 * VOXEL
    grid = vdb.FloatGrid(band)
    grid.name, grid.gridClass = "bunny", vdb.GridClass.LEVEL_SET
    grid.copyFromArray(np.clip(distance(low + VOXEL * index), -band, band).astype(np.float32))
    grid.transform = vdb.createLinearTransform(VOXEL)
    grid.transform.translate(low)
    vdb.write(path, grids=[grid])


if __name__ == "__main__":
    main(sys.argv[1])
