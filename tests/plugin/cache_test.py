#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The samples of fits and of a simulation cache, as their scripts run them; the cache small: 32 voxels,
3 frames. Arguments: the octetvdb command. Needs Blender for the cache.
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import pyopenvdb as vdb

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples")


def read_frame(path, n):
    """Density and velocity at the centres of n^3 voxels; Mantaflow keeps velocities on faces."""
    density, v = np.zeros((n, n, n), np.float32), np.zeros((n + 1, n + 1, n + 1, 3), np.float32)
    vdb.read(path, "density").copyToArray(density)
    vdb.read(path, "velocity").copyToArray(v)
    v = v.astype(float)
    return density.astype(float), np.stack(
        [(v[:-1, :-1, :-1, 0] + v[1:, :-1, :-1, 0]) / 2,
         (v[:-1, :-1, :-1, 1] + v[:-1, 1:, :-1, 1]) / 2,
         (v[:-1, :-1, :-1, 2] + v[:-1, :-1, 1:, 2]) / 2], -1)


def trilinear(grid, points):
    """Values at points in voxels, and those at the eight corners around each."""
    low = np.clip(np.floor(points).astype(int), 0, np.array(grid.shape) - 2)
    t = np.clip(points - low, 0, 1)
    corners = [np.array(c) for c in np.ndindex(2, 2, 2)]
    values = [grid[tuple(np.moveaxis(low + c, -1, 0))] for c in corners]
    return sum(v * np.prod(np.where(c == 1, t, 1 - t), -1)
               for c, v in zip(corners, values)), values


def advect(density, x, move):
    """Mantaflow's own step: MacCormack's, of first order where it leaves the range around."""
    forward, around = trilinear(density, x - move)
    result = forward + (density - trilinear(forward, x + move)[0]) / 2
    outside = (result < np.minimum.reduce(around)) | (result > np.maximum.reduce(around))
    return np.where(outside, forward, result)


class Scripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_command(self, *command):
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_fits_follow_their_guides(self):
        # Fails itself when a guide is missed by 5 % or a wall is not tight.
        rows = self.run_command(sys.executable, f"{SAMPLES}/fit/fit.py", OCTETVDB, "fit")
        names = [row.split("|")[4].strip() for row in rows.splitlines()[2:]]
        self.assertEqual(len(names), 14)
        # The README lists the same guides.
        with open(f"{SAMPLES}/fit/README.md") as file:
            readme = file.read()
        for name in names:
            if not name.startswith("flux through walls"):
                self.assertIn(f"| {name} |", readme)

    def make_cache(self):
        self.run_command("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                         f"{SAMPLES}/cache/make_cache.py", "--", "--out", "cache", "--resolution",
                         "32", "--frames", "3")

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_velocity_is_voxels_per_time_unit_of_mantaflow(self):
        """A second has 2.5 units, times the time scale 2: moved by that, density becomes the next
        frame's, away from what adds smoke or stops it; by 5 % more or less it does not."""
        self.make_cache()
        n, voxel, frames_per_second = 32, 3 / 32, 24
        before, after = (read_frame(f"{self.folder}/cache/data/fluid_data_{frame:04d}.vdb", n)
                         for frame in (2, 3))
        x = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).astype(float)
        far = np.all((x >= 4) & (x < n - 4), axis=-1)
        for centre, radius in (((1.55, 1.5, 0.5), 0.3), ((1.5, 1.5, 1.3), 0.35)):
            distance = np.linalg.norm((x + 0.5) * voxel - np.array(centre), axis=-1)
            far &= distance > radius + 2 * voxel

        def left(per_second):
            moved = advect(before[0], x, per_second / frames_per_second * before[1])
            return (np.linalg.norm((moved - after[0])[far])
                    / np.linalg.norm((after[0] - before[0])[far]))

        self.assertLess(left(5), 0.003)
        self.assertGreater(left(5 * 0.95), 0.03)
        self.assertGreater(left(5 * 1.05), 0.03)

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_cache_is_compressed_and_cleaned(self):
        self.make_cache()
        self.run_command(sys.executable, f"{SAMPLES}/cache/measure.py", OCTETVDB, "cache/data", "out",
                         "--cells", "4", "8")
        with open(os.path.join(self.folder, "out/measured.json")) as file:
            coarse, sharp, fine, finest = json.load(file)
        for row in (coarse, sharp, fine, finest):
            self.assertGreater(row["before"], 1e-5)
            self.assertLess(row["after"], 1e-6)  # of floats
            self.assertLess(row["form"], 1e-12)
            self.assertGreater(row["ratio"], 1)
        # Smaller cells hold more, and so do corrected coefficients on the same cells.
        self.assertLess(fine["error"], 0.9 * coarse["error"])
        self.assertLess(sharp["error"], 0.9 * coarse["error"])
        self.assertLess(finest["error"], 0.9 * fine["error"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
