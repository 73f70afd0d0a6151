#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""octetvdb verify on our own grids, on ones that OpenVDB's Python module wrote, and on Blender's
fluid simulation; exit codes; and tracer particles in a closed box.
Arguments: the commands octetvdb and advect.
"""
import glob
import importlib.util
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

import pyopenvdb as vdb

OCTETVDB, ADVECT = (os.path.abspath(p) for p in sys.argv[1:3])
del sys.argv[1:3]
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples")
sys.path.insert(0, SAMPLES)
spec = importlib.util.spec_from_file_location(
    "particles", os.path.join(SAMPLES, "conservation/particles.py"))
particles = importlib.util.module_from_spec(spec)
spec.loader.exec_module(particles)


def call(*arguments):
    return subprocess.run([OCTETVDB, *arguments], capture_output=True, text=True)


class Verify(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def certificates(self, path, *options):
        result = call("verify", path, "--json", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return {g["name"]: g["certificate"] for g in json.loads(result.stdout)["grids"]}

    def test_exit_codes(self):
        box = os.path.join(SAMPLES, "box/box.octet.json")
        out = self.path("box.vdb")
        baked = call("bake", box, "-o", out, "--form", "velocity", "--resolution", "24", "--grid",
                     "staggered", "--json")
        self.assertEqual(baked.returncode, 0, baked.stderr)
        grid = json.loads(baked.stdout)["files"][0]["grids"][0]
        self.assertEqual(grid["method"], "circulations")
        # What bake says is what verify finds in the file.
        self.assertEqual(self.certificates(out)["velocity"], grid["certificate"])
        self.assertEqual(call("verify", out, "--max-divergence", "2e-6").returncode, 0)
        self.assertEqual(call("verify", out, "--max-divergence", "1e-12").returncode, 1)
        self.assertEqual(call("verify", out, "--grid", "absent").returncode, 2)
        self.assertEqual(call("verify", self.path("absent.vdb")).returncode, 2)
        self.assertEqual(call("verify", out, "--max-divergence", "x").returncode, 2)
        self.assertEqual(call("verify", box).returncode, 2)

    def test_closed_samples_at_three_resolutions(self):
        """Finer than the fine cells, alike, coarser: staggered, and sampled at the same faces."""
        closed = 0
        for asset in sorted(glob.glob(f"{SAMPLES}/*/*.octet.json")):
            with open(asset) as file:
                forms = [f for f in json.load(file)["forms"] if f["degree"] == 2]
            for form in forms:
                frames = ["--frames", "1-1"] if "frames" in form else []
                for resolution in ("14", "28", "44"):
                    grids = []
                    for extra in ([], ["--method", "samples"]):
                        out = self.path("out.vdb")
                        baked = call("bake", asset, "-o", out, "--form", form["name"], "--levels",
                                     "1", "--resolution", resolution, "--grid", "staggered", "--json",
                                     *frames, *extra)
                        self.assertEqual(baked.returncode, 0, baked.stderr)
                        grids.append(json.loads(baked.stdout)["files"][0]["grids"][0])
                    ours, sampled = grids
                    found = ours["certificate"]["divergence_max"]
                    print(f"{os.path.basename(asset)} {form['name']} {resolution}: {ours['method']}"
                          f" {found:.2g}, sampled {sampled['certificate']['divergence_max']:.2g}")
                    if ours["method"] == "circulations":
                        closed += 1
                        self.assertLessEqual(found, 2e-6)
                        self.assertGreater(sampled["certificate"]["divergence_max"], found)
                    else:
                        self.assertTrue(ours["note"])  # it says why
        self.assertGreaterEqual(closed, 9)

    def write_linear(self, path, triple):
        """v = (0.5 x, 0.25 y, x) on 8^3 voxels of size 0.5: divergence 0.75, curl (0, -1, 0)."""
        grids = [vdb.FloatGrid() for _ in range(3)] if triple else [vdb.Vec3SGrid()]
        accessors = [g.getAccessor() for g in grids]
        for i in range(8):
            for j in range(8):
                for k in range(8):
                    value = (0.25 * i, 0.125 * j, 0.5 * i)
                    if triple:
                        for axis in range(3):
                            accessors[axis].setValueOn((i, j, k), value[axis])
                    else:
                        accessors[0].setValueOn((i, j, k), value)
        for axis, grid in enumerate(grids):
            grid.name = f"vel.{'xyz'[axis]}" if triple else "vel"
            grid.transform = vdb.createLinearTransform(0.5)
        vdb.write(path, grids=grids)

    def test_grids_made_by_others(self):
        fastest = (1.75 ** 2 + 0.875 ** 2 + 3.5 ** 2) ** 0.5
        for triple in (False, True):
            self.write_linear(self.path("linear.vdb"), triple)
            found = self.certificates(self.path("linear.vdb"), "--grid", "vel")["vel"]
            self.assertEqual(found["scheme"], "CD_2ND")
            self.assertEqual(found["active_voxels"], 512)
            self.assertEqual(found["inside_voxels"], 216)
            self.assertAlmostEqual(found["divergence_max"], 0.75 * 0.5 / fastest, delta=1e-6)
            self.assertAlmostEqual(found["divergence_rms"], 0.75 * 0.5 / fastest, delta=1e-6)
            self.assertAlmostEqual(found["curl_max"], 0.5 / fastest, delta=1e-6)
            self.assertAlmostEqual(found["speed_max"], fastest, delta=1e-5)
            # Values at the border stand for the faces there.
            self.assertAlmostEqual(found["outflow"], 16 * (1.75 + 0.875 + 0) + 0, delta=1e-4)

    def write_tile(self, path, triple):
        """One value in 1024^3 voxels, in a file of some kilobytes."""
        value = (1.0, 0.5, 0.25)
        grids = [vdb.FloatGrid() for _ in range(3)] if triple else [vdb.Vec3SGrid()]
        for axis, grid in enumerate(grids):
            grid.fill((0, 0, 0), (1023,) * 3, value[axis] if triple else value, True)
            grid.name = f"vel.{'xyz'[axis]}" if triple else "vel"
            grid.transform = vdb.createLinearTransform(2.0**-10)
        vdb.write(path, grids=grids)

    def test_a_tile_costs_no_more_than_its_border(self):
        path = self.path("tile.vdb")
        for triple in (False, True):
            self.write_tile(path, triple)
            self.assertLess(os.path.getsize(path), 30000)
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            found = self.certificates(path)["vel"]
            self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, 1)
            self.assertEqual(found["active_voxels"], 1024**3)
            self.assertEqual(found["inside_voxels"], 1022**3)
            self.assertEqual(found["divergence_free_voxels"], 1022**3)
            self.assertEqual(found["divergence_max"], 0)
            self.assertEqual(found["outflow"], 0)
            self.assertAlmostEqual(found["throughflow"], 2 * 1.75)
            self.assertAlmostEqual(found["energy"], (1 + 0.25 + 0.0625) / 2)

    @unittest.skipUnless(shutil.which("blender"), "needs blender")
    def test_mantaflow(self):
        cache = self.path("cache")
        script = os.path.join(SAMPLES, "conservation/mantaflow.py")
        subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                        script, "--", cache, "32", "3"], check=True, capture_output=True)
        path = sorted(glob.glob(f"{cache}/data/*.vdb"))[-1]
        found = self.certificates(path, "--grid", "velocity")["velocity"]
        self.assertEqual(found["scheme"], "FD_1ST")
        self.assertGreater(found["inside_voxels"], 500)
        # Its pressure solver stops at a tolerance; that is far from no divergence, and from rounding.
        self.assertLess(found["divergence_max"], 0.05)
        self.assertGreater(found["divergence_max"], 1e-6)
        self.assertEqual(call("verify", path, "--max-divergence", "1e-6").returncode, 1)

    def test_particles_stay_and_do_not_clump(self):
        reports = particles.run(OCTETVDB, ADVECT, self.folder, steps=500, count=6000)
        ours, centres = reports["circulations"], reports["centre samples"]
        self.assertLess(ours["divergence_max"], 2e-6)
        self.assertEqual(ours["outside"], 0)
        self.assertLess(ours["dispersion_end"], 1.2)
        self.assertGreater(centres["outside"], 0)


if __name__ == "__main__":
    unittest.main()
