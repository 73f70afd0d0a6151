#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Baked values, bit for bit: the hashes of a few bakes and refinements are those of
tests/data/bake_hashes.txt. A change that is meant to keep values shows here that it does; one that
is meant to change them writes the file anew, with OCTETVDB_WRITE_HASHES=1, and says why.
Argument: the command octetvdb.
"""
import hashlib
import os
import unittest

import numpy as np
import pyopenvdb as vdb

import command

OCTETVDB = command.from_arguments()
HASHES = os.path.join(command.DATA, "bake_hashes.txt")


def sample(name):
    return os.path.join(command.SAMPLES, name)


BAKES = {
    "box": [sample("box/box.octet.json"), "--resolution", 40],
    "box staggered": [sample("box/box.octet.json"), "--form", "velocity", "--grid", "staggered",
                      "--resolution", 32],
    "box samples": [sample("box/box.octet.json"), "--form", "velocity", "--method", "samples",
                    "--resolution", 32],
    "box curl": [sample("box/box.octet.json"), "--form", "potential", "--d", "--resolution", 32],
    "ball": [sample("ball/ball.octet.json"), "--resolution", 32],
    "ball open": [sample("ball/ball.octet.json"), "--resolution", 24, "--boundary", "open"],
    "ball whitney": [sample("ball/ball.octet.json"), "--resolution", 24, "--reconstruction",
                     "whitney"],
    "lattice": [sample("lattice/lattice.octet.json"), "--resolution", 32],
    "lattice expansion": [sample("lattice/lattice.octet.json"), "--resolution", 24, "--boundary",
                          "expansion"],
    "animated": [sample("animated/animated.octet.json"), "--voxel-size", 0.2, "--frames", "1-2"],
    "M_X": [sample("thesis/M_X.octet.json"), "--resolution", 32],
    "M_B projection": [sample("thesis/M_B.octet.json"), "--resolution", 24, "--boundary",
                       "projection"],
}
REFINEMENTS = {
    "refined ball": [sample("ball/ball.octet.json"), "--levels", 1],
    "refined lattice": [sample("lattice/lattice.octet.json"), "--levels", 2],
    "refined M_E": [sample("thesis/M_E.octet.json"), "--levels", 2],
}


def hash_of_grid(grid):
    """Of name, transform, bounding box, active voxels and their values."""
    low, high = grid.evalActiveVoxelBoundingBox()
    shape = tuple(b - a + 1 for a, b in zip(low, high))
    vector = isinstance(grid, vdb.Vec3SGrid)
    values = np.zeros(shape + ((3,) if vector else ()), np.float32)
    grid.copyToArray(values, ijk=low)
    mask = np.zeros(shape, bool)
    for item in grid.citerOnValues():
        if item.count == 1:
            mask[tuple(c - a for c, a in zip(item.min, low))] = True
        else:
            mask[tuple(slice(c - a, d - a + 1) for c, d, a in zip(item.min, item.max, low))] = True
    digest = hashlib.sha256()
    transform = [grid.transform.indexToWorld(p)
                 for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
    digest.update(repr((grid.name, transform, low, high)).encode())
    digest.update(np.where(mask[..., None] if vector else mask, values, 0).tobytes())
    digest.update(np.packbits(mask).tobytes())
    return digest.hexdigest()[:32]


def hashes_of_bake(name, arguments):
    with command.temporary_folder() as folder:
        result = OCTETVDB.run("bake", *arguments, "-o", os.path.join(folder, "out.vdb"))
        assert result.returncode == 0, result.stderr
        found = {}
        for file in sorted(os.listdir(folder)):
            for grid in vdb.readAll(os.path.join(folder, file))[0]:
                place = file.replace("out", "").replace(".vdb", "").strip(".")
                found[" ".join(filter(None, (name, place, grid.name)))] = hash_of_grid(grid)
        return found


def hashes_of_refinement(name, arguments):
    with command.temporary_folder() as folder:
        path = os.path.join(folder, "out.json")
        result = OCTETVDB.run("refine", *arguments, "-o", path)
        assert result.returncode == 0, result.stderr
        with open(path, "rb") as file:
            return {name: hashlib.sha256(file.read()).hexdigest()[:32]}


def all_hashes():
    jobs = [(hashes_of_bake, *item) for item in BAKES.items()]
    jobs += [(hashes_of_refinement, *item) for item in REFINEMENTS.items()]
    found = {}
    for part in command.in_parallel(lambda job: job[0](*job[1:]), jobs):
        found.update(part)
    return found


class BakeHashes(unittest.TestCase):
    def test_values_are_those_of_the_file(self):
        found = all_hashes()
        if os.environ.get("OCTETVDB_WRITE_HASHES"):
            with open(HASHES, "w") as file:
                for name, value in sorted(found.items()):
                    file.write(f"{value}  {name}\n")
        with open(HASHES) as file:
            expected = {line[34:].strip(): line[:32] for line in file}
        changed = sorted(name for name in expected.keys() | found.keys()
                         if expected.get(name) != found.get(name))
        self.assertEqual(changed, [])


if __name__ == "__main__":
    unittest.main()
