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

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples")


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

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_cache_is_compressed_and_cleaned(self):
        self.run_command("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                         f"{SAMPLES}/cache/make_cache.py", "--", "--out", "cache", "--resolution",
                         "32", "--frames", "3")
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
