#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`octetvdb sample` on velocity grids as programs write them: classes, types, transforms, units,
sequences, bad input. Arguments: the octetvdb command.

Velocities are linear functions, which trilinear sampling reproduces: fluxes and circulations must be
those of the function, whatever the grid.
"""
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import pyopenvdb as vdb

import command

sys.path.insert(0, command.SAMPLES)
import octet_asset as oa

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SIZE = (1.5, 2.0, 1.0)
# Rows: gradient of each component; trace 0, so without divergence, and with curl.
GRADIENT = np.array([[0.5, -1.0, 0.25], [0.75, -0.25, 0.5], [0.0, 1.5, -0.25]])
OFFSET = np.array([1.0, -0.5, 2.0])


def velocity(p):
    return GRADIENT @ np.asarray(p) + OFFSET


def grid_of(field, matrix, count, staggered=False, kind=vdb.Vec3SGrid):
    """A grid of field(world position), its transform being `matrix` (columns: steps, origin)."""
    ijk = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), -1).astype(float)
    components = []
    for c in range(3):
        index = ijk - 0.5 * np.eye(3)[c] if staggered else ijk
        world = index @ matrix[:3, :3].T + matrix[:3, 3]
        components.append(np.apply_along_axis(field, -1, world)[..., c])
    grid = kind()
    grid.copyFromArray(np.stack(components, -1).astype(np.float32))
    grid.transform = vdb.createLinearTransform(
        [list(map(float, row)) + [0.0] for row in matrix[:3, :3].T]
        + [list(map(float, matrix[:3, 3])) + [1.0]])
    grid.name = "velocity"
    if staggered:
        grid.gridClass = vdb.GridClass.STAGGERED
    return grid


def matrix_of(steps, origin):
    result = np.eye(4)
    result[:3, :3] = steps
    result[:3, 3] = origin
    return result


PLAIN = matrix_of(0.25 * np.eye(3), (-1.25, -1.5, -1.0))
COUNT = (12, 14, 10)


def turned(angle, scale, origin):
    c, s = math.cos(angle), math.sin(angle)
    return matrix_of(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.diag(scale), origin)


class Sample(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.cage = oa.box((2, 3, 2), SIZE)
        oa.write(self.path("cage.octet.json"), "cage", self.cage, [])

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_sample(self, *arguments, code=0):
        result = subprocess.run(
            [OCTETVDB, "--progress", "none", "sample", self.path("cage.octet.json"), *arguments, "-o",
             self.path("out.octet.json"), "--json"], capture_output=True, text=True)
        self.assertEqual(result.returncode, code, result.stderr)
        if code:
            self.assertFalse(os.path.exists(self.path("out.octet.json")))
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            return result.stderr
        with open(self.path("out.octet.json")) as file:
            return json.loads(result.stdout), json.load(file)

    def check(self, asset, degree, factor=1.0, tolerance=2e-6, frame=None):
        form = next(f for f in asset["forms"] if f["name"] == "velocity")
        self.assertEqual(form["degree"], degree)
        values = form["values"] if frame is None else form["frames"][str(frame)]
        got = {tuple(s): v for s, v in zip(form["simplices"], values)}
        simplices = self.cage.facets if degree == 2 else self.cage.edges
        measure = self.cage.flux if degree == 2 else self.cage.circulation
        for simplex in simplices:
            want = factor * measure(lambda p: tuple(velocity(p)), simplex)
            self.assertAlmostEqual(got.get(simplex, 0), want, delta=tolerance, msg=simplex)

    def write(self, *grids, name="v.vdb", half=False):
        for grid in grids:
            grid.saveFloatAsHalf = half
        vdb.write(self.path(name), list(grids))
        return self.path(name)

    def test_collocated(self):
        source = self.write(grid_of(velocity, PLAIN, COUNT))
        for degree in (1, 2):
            report, asset = self.run_sample(source, "--degree", str(degree))
            self.check(asset, degree)
            frame = report["frames"][0]
            self.assertFalse(frame["staggered"])
            # Two cells across the cage: everything is boundary.
            self.assertLess(frame["error"], 0.2)
            self.assertEqual(report["source_bytes"], os.path.getsize(source))
            self.assertEqual(report["asset_bytes"], os.path.getsize(self.path("out.octet.json")))

    def test_staggered(self):
        report, asset = self.run_sample(self.write(grid_of(velocity, PLAIN, COUNT, True)))
        self.check(asset, 2)
        self.assertTrue(report["frames"][0]["staggered"])
        self.assertLess(report["frames"][0]["source_divergence"], 1e-6)

    def test_staggered_is_not_read_as_collocated(self):
        grid = grid_of(velocity, PLAIN, COUNT, True)
        grid.gridClass = vdb.GridClass.UNKNOWN
        _, asset = self.run_sample(self.write(grid))
        with self.assertRaises(AssertionError):
            self.check(asset, 2, tolerance=1e-2)

    def test_half(self):
        source = self.write(grid_of(velocity, PLAIN, COUNT), half=True)
        self.check(self.run_sample(source)[1], 2, tolerance=1e-3)

    def test_turned_and_stretched(self):
        matrix = turned(0.5, (0.2, 0.3, 0.15), (-0.5, -1.8, -0.5))
        source = self.write(grid_of(velocity, matrix, (20, 20, 16)))
        self.check(self.run_sample(source)[1], 2)

    def test_float_triples(self):
        for names in (("vel.x", "vel.y", "vel.z"), ("vel_x", "vel_y", "vel_z"),
                      ("velX", "velY", "velZ")):
            for faces in (False, True):
                grids = []
                for c, name in enumerate(names):
                    # On faces each component has a transform of its own.
                    shift = matrix_of(np.eye(3), -0.125 * np.eye(3)[c] if faces else np.zeros(3))
                    whole = grid_of(velocity, shift @ PLAIN, COUNT)
                    array = np.zeros(COUNT + (3,), np.float32)
                    whole.copyToArray(array)
                    grid = vdb.FloatGrid()
                    grid.copyFromArray(np.ascontiguousarray(array[..., c]))
                    grid.transform, grid.name = whole.transform, name
                    grids.append(grid)
                source = self.write(*grids)
                for extra in ((), ("--grid", "vel")):
                    report, asset = self.run_sample(source, *extra)
                    self.check(asset, 2)
                    self.assertEqual(report["frames"][0]["staggered"], faces)

    def test_units(self):
        source = self.write(grid_of(velocity, PLAIN, COUNT))
        for unit, factor in (("units/s", 1), ("units/frame", 30), ("voxels/s", 0.25),
                             ("voxels/frame", 7.5)):
            _, asset = self.run_sample(source, "--velocity-unit", unit, "--fps", "30")
            self.check(asset, 2, factor, 1e-5 * factor)
            self.assertEqual(asset["frames_per_second"], 30)
        self.check(self.run_sample(source, "--scale", "-2.5")[1], 2, -2.5, 1e-5)

    def test_voxels_turn_with_the_grid(self):
        matrix = turned(0.5, (0.2, 0.3, 0.15), (-0.5, -1.8, -0.5))
        inverse = np.linalg.inv(matrix[:3, :3])
        source = self.write(grid_of(lambda p: inverse @ velocity(p), matrix, (20, 20, 16)))
        self.check(self.run_sample(source, "--velocity-unit", "voxels/s")[1], 2, 1, 1e-5)

    def test_sequence(self):
        files = []
        for frame in (7, 8, 10):
            files.append(self.write(grid_of(lambda p: frame * velocity(p), PLAIN, COUNT),
                                    name=f"v.{frame:04d}.vdb"))
        report, asset = self.run_sample(*files)
        for frame in (7, 8, 10):
            self.check(asset, 2, frame, 1e-5 * frame, frame)
        self.assertEqual([f["frame"] for f in report["frames"]], [7, 8, 10])
        error = self.run_sample_again(files[0], files[0])
        self.assertIn("frame number 7", error)

    def run_sample_again(self, *arguments):
        os.remove(self.path("out.octet.json"))
        return self.run_sample(*arguments, code=2)

    def test_divergence_free(self):
        # A source in the middle is taken away, what has no divergence stays.
        source = self.write(grid_of(velocity, PLAIN, COUNT))
        report, asset = self.run_sample(source, "--divergence-free")
        self.check(asset, 2)
        spread = self.write(grid_of(lambda p: velocity(p) + np.array([0.5 * p[0], 0, 0]), PLAIN,
                                    COUNT), name="w.vdb")
        report, asset = self.run_sample(spread, "--divergence-free")
        frame = report["frames"][0]
        self.assertGreater(frame["before"], 1e-2)
        self.assertLess(frame["after"], 1e-12)
        report, _ = self.run_sample(spread, "--divergence-free", "--boundary-flux", "zero")
        self.assertLess(report["frames"][0]["after"], 1e-12)
        report, _ = self.run_sample(source, "--degree", "1", "--curl-free")
        self.assertLess(report["frames"][0]["after"], 1e-12)

    def test_corrections_bring_the_limit_nearer(self):
        self.cage = oa.box((4, 6, 4), SIZE)
        oa.write(self.path("cage.octet.json"), "cage", self.cage, [])
        wave = self.write(grid_of(lambda p: np.array([math.sin(5 * p[1]), 0, math.sin(5 * p[0])]),
                                  PLAIN, COUNT))
        errors = []
        for count in ("0", "1", "4"):
            report, _ = self.run_sample(wave, "--divergence-free", "--corrections", count)
            errors.append(report["frames"][0]["error"])
            self.assertLess(report["frames"][0]["after"], 1e-12)
        self.assertLess(errors[1], 0.9 * errors[0])
        self.assertLess(errors[2], 0.9 * errors[1])

    def test_other_forms_stay(self):
        heights = {(v,): p[0] for v, p in enumerate(self.cage.vertices)}
        oa.write(self.path("cage.octet.json"), "cage", self.cage,
                 [oa.form("height", 0, "m", heights)])
        source = self.write(grid_of(velocity, PLAIN, COUNT))
        _, asset = self.run_sample(source)
        self.assertEqual([f["name"] for f in asset["forms"]], ["height", "velocity"])

    def tile(self):
        """One value in 1024^3 voxels around the cage, in a file of some kilobytes."""
        grid = vdb.Vec3SGrid()
        grid.fill((0, 0, 0), (1023,) * 3, (1.0, 0.5, 0.25), True)
        grid.name = "velocity"
        step = 2.0**-8
        grid.transform = vdb.createLinearTransform(
            [[step, 0, 0, 0], [0, step, 0, 0], [0, 0, step, 0], [-1, -1, -1, 1]])
        return self.write(grid)

    def test_a_tile_is_read_as_one(self):
        source = self.tile()
        small = oa.box((1, 1, 1), (0.5, 0.5, 0.5))
        oa.write(self.path("cage.octet.json"), "cage", small, [])
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        report, _ = self.run_sample(source, "--compare", "100000")
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, 2)
        frame = report["frames"][0]
        self.assertEqual(frame["active_voxels"], 1024**3)
        self.assertAlmostEqual(frame["speed"], math.sqrt(1.3125), places=6)
        self.assertLess(frame["error"], 1e-6)

    def test_sigterm_ends_it_soon(self):
        process = subprocess.Popen(
            [OCTETVDB, "--progress", "none", "sample", self.path("cage.octet.json"), self.tile(), "-o",
             self.path("out.octet.json")], stderr=subprocess.DEVNULL)
        time.sleep(1)
        self.assertLess(command.stop(process), command.AT_ONCE)
        self.assertEqual(process.returncode, 128 + signal.SIGTERM)
        self.assertFalse(os.path.exists(self.path("out.octet.json")))

    def test_bad_input_is_refused(self):
        good = self.write(grid_of(velocity, PLAIN, COUNT))
        self.assertIn("cannot be read", self.run_sample(self.path("none.vdb"), code=2))
        with open(self.path("text.vdb"), "w") as file:
            file.write("no grid")
        self.assertIn("not a readable .vdb", self.run_sample(self.path("text.vdb"), code=2))
        with open(good, "rb") as whole, open(self.path("cut.vdb"), "wb") as part:
            part.write(whole.read()[:2000])
        self.assertIn("not a readable .vdb", self.run_sample(self.path("cut.vdb"), code=2))
        self.assertIn('"other"', self.run_sample(good, "--grid", "other", code=2))
        two = []
        for name in ("a", "b"):
            grid = grid_of(velocity, PLAIN, COUNT)
            grid.name = name
            two.append(grid)
        self.assertIn("choose one", self.run_sample(self.write(*two, name="two.vdb"), code=2))
        density = vdb.FloatGrid()
        density.name = "density"
        self.assertIn("density", self.run_sample(self.write(density, name="d.vdb"), code=2))
        empty = vdb.Vec3SGrid()
        empty.name = "velocity"
        self.assertIn("no active voxel", self.run_sample(self.write(empty, name="e.vdb"), code=2))
        nan = grid_of(velocity, PLAIN, COUNT)
        nan.getAccessor().setValueOn((5, 6, 7), (1.0, math.nan, 0.0))
        self.assertIn("(5, 6, 7) is not finite", self.run_sample(self.write(nan, name="n.vdb"), code=2))
        far = grid_of(velocity, matrix_of(0.25 * np.eye(3), (50, 0, 0)), COUNT)
        self.assertIn("no voxel lies in the cage", self.run_sample(self.write(far, name="f.vdb"),
                                                                   code=2))
        self.assertIn("frame number", self.run_sample(good, self.path("e.vdb"), code=2))
        self.assertIn("--divergence-free",
                      self.run_sample(good, "--degree", "1", "--divergence-free", code=2))
        self.assertIn("scale", self.run_sample(good, "--scale", "0", code=2))


if __name__ == "__main__":
    unittest.main(verbosity=2)
