#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The add-on in the real Blender, headless and in a window, and against command line and module.

Arguments: the add-on's zip, the octetvdb command. PYTHONPATH names the build tree's module.
With OCTETVDB_SCREENSHOT=file the panel's picture is kept; with OCTETVDB_UPDATE_GOLDEN=1 the golden
picture is replaced.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import pyopenvdb

import octetvdb

ZIP, OCTETVDB = map(os.path.abspath, sys.argv[1:3])
del sys.argv[1:3]
HERE = os.path.dirname(os.path.abspath(__file__))
GOLDEN = os.path.join(HERE, "swirl_240x135.png")
# Colours go from 0 to 1. Cycles with a fixed seed repeats itself to the bit on one machine; another
# processor rounds differently, which moves single samples of 32: noise, that blocks average out.
MOST_MEAN_DIFFERENCE, MOST_BLOCK_DIFFERENCE = 0.01, 0.03


class Addon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def folder(self, name):
        path = os.path.join(self.scratch.name, name)
        os.makedirs(path, exist_ok=True)
        return path

    def blender(self, script, *arguments, before=(), options=("-b",), timeout=280):
        """Runs a script in Blender with settings of its own; returns what it printed."""
        home = self.folder("home_" + script)
        environment = {**os.environ, "BLENDER_USER_SCRIPTS": home, "BLENDER_USER_CONFIG": home,
                       "PYTHONPATH": ""}
        done = subprocess.run([*before, "blender", *options, "--factory-startup",
                               "--python-exit-code", "1", "--python", os.path.join(HERE, script),
                               "--", *arguments], capture_output=True, text=True, timeout=timeout,
                              env=environment)
        output = done.stdout + done.stderr
        for line in output.splitlines():
            if line.startswith(("PASSED", "MEASURED", "DIFFERENCE")):
                print(line)
        self.assertEqual(done.returncode, 0, output[-6000:])
        self.assertNotIn("Traceback", output)
        return output

    def assert_all_passed(self, output, names):
        self.assertEqual(set(re.findall(r"^PASSED (\w+)", output, re.M)), set(names))

    def test_1_headless(self):
        checks = []
        for room in glob.glob(os.path.join(HERE, "checks", "*.py")):
            with open(room) as file:
                checks += re.findall(r"^def check_(\w+)", file.read(), re.M)
        self.assertGreater(len(checks), 15)
        output = self.blender("in_blender.py", ZIP, self.folder("files"))
        self.assert_all_passed(output, checks)

    def test_2_command_line_module_and_blender_bake_the_same(self):
        asset = os.path.join(self.folder("files"), "same.octet.json")
        by_command, by_module = (os.path.join(self.scratch.name, f"{who}.vdb")
                                 for who in ("command", "module"))
        subprocess.run([OCTETVDB, "bake", asset, "-o", by_command, "--target", "blender",
                        "--resolution", "32", "--boundary", "walls"], check=True,
                       capture_output=True)
        octetvdb.bake(octetvdb.ControlAsset.read(asset), by_module, target="blender",
                      resolution=32, boundary="walls")
        by_blender = os.path.join(self.folder("files"), "box.vdb")
        reference = self.grids(by_blender)
        self.assertEqual(set(reference), {"velocity", "density"})
        for other in (by_command, by_module):
            found = self.grids(other)
            self.assertEqual(set(found), set(reference))
            for name, (metadata, transform, indices, values) in found.items():
                self.assertEqual(metadata, reference[name][0])
                self.assertEqual(transform, reference[name][1])
                self.assertTrue(np.array_equal(indices, reference[name][2]))
                self.assertTrue(np.array_equal(values, reference[name][3]), name)

    @staticmethod
    def grids(path):
        result = {}
        for grid in pyopenvdb.readAll(path)[0]:
            items = sorted((item.min, item.value) for item in grid.iterOnValues())
            result[grid.name] = (sorted(map(str, grid.metadata.items())), grid.transform.info(),
                                 np.array([i for i, _ in items]),
                                 np.array([v for _, v in items], np.float32))
        return result

    def test_3_render(self):
        update = ["update"] if os.environ.get("OCTETVDB_UPDATE_GOLDEN") else []
        output = self.blender("render_check.py", ZIP, self.folder("render"), GOLDEN, *update)
        mean, block, contrast = map(float, re.search(r"^DIFFERENCE (\S+) (\S+) (\S+)", output,
                                                     re.M).groups())
        self.assertGreater(contrast, 0.05, "there is nothing in the picture")
        self.assertLess(mean, MOST_MEAN_DIFFERENCE)
        self.assertLess(block, MOST_BLOCK_DIFFERENCE)

    def test_4_window(self):
        picture = os.path.join(self.folder("pictures"), "panel.png")
        output = self.blender(
            "in_window.py", ZIP, self.folder("window"), picture,
            before=("xvfb-run", "-a", "-s", "-screen 0 1280x900x24"),
            options=("--enable-event-simulate", "--window-geometry", "0", "0", "1280", "900"))
        self.assertIn("DONE", output)
        self.assert_all_passed(output, {"undo", "escape", "whole_bake", "picture"})
        if os.environ.get("OCTETVDB_SCREENSHOT"):
            shutil.copy(picture, os.environ["OCTETVDB_SCREENSHOT"])


if __name__ == "__main__":
    unittest.main()
