#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bakes read back by OpenVDB's own Python module and vdb_print: class, type, transform and values,
for every target. Arguments: the octetvdb command.

The asset's forms have known fields: a linear function, a constant gradient and a constant flux, on a
creased box (flat walls, where all of these are reproduced exactly). So every voxel's value tells where
in the world the voxel must lie. A constant density is reproduced where the cage is a piece of the
lattice; elsewhere its total is kept, while the cells' volumes change by smoothing a little otherwise
than the masses.
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import pyopenvdb as vdb

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples"))
import octet_asset as oa

OCTETVDB = sys.argv.pop(1)
SIZE = (2.0, 3.0, 1.5)
SLOPE = (1.0, -2.0, 0.5)
FLOW = (0.25, -1.5, 0.75)
DENSITY = 1.25

# Per target: name of the velocity grid, class of vectors, up axis, voxels cornered at ijk.
TARGETS = {
    "openvdb": ("flow", "unknown", "Z", False),
    "blender": ("velocity", "unknown", "Z", True),
    "houdini": ("vel", "unknown", "Y", False),
    "arnold": ("velocity", "unknown", "Z", False),
    "renderman": ("velocity", "fog volume", "Z", False),
}


def linear(p):
    return sum(s * x for s, x in zip(SLOPE, p)) + 4


def make_asset(path):
    cage = oa.box((2, 3, 2), SIZE)
    heights = {(v,): linear(p) for v, p in enumerate(cage.vertices)}
    slopes = {e: heights[(e[1],)] - heights[(e[0],)] for e in cage.edges}
    fluxes = {f: cage.flux(lambda p: FLOW, f) for f in cage.facets}
    volume = SIZE[0] * SIZE[1] * SIZE[2] / len(cage.tetrahedra)
    masses = {t: DENSITY * volume for t in cage.tetrahedra}
    oa.write(path, "constants", cage,
             [oa.form("height", 0, "m", heights), oa.form("slope", 1, "1", slopes),
              oa.form("flow", 2, "m/s", fluxes), oa.form("mass", 3, "kg", masses)])


def turn(v, up):
    """From Z up to the target's up axis."""
    return v if up == "Z" else (v[0], v[2], -v[1])


def turn_back(v, up):
    return v if up == "Z" else (v[0], -v[2], v[1])


class ReadBack(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.asset = os.path.join(cls.folder.name, "constants.octet.json")
        make_asset(cls.asset)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def bake(self, *options):
        out = os.path.join(self.folder.name, "out.vdb")
        result = subprocess.run([OCTETVDB, "bake", self.asset, "-o", out, "--voxel-size", "0.11",
                                 "--json", *options], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return out, json.loads(result.stdout)

    def world(self, grid, ijk, cornered):
        """Where the value of voxel ijk was sampled: cornered grids are drawn centred at ijk + 1/2."""
        offset = 0.5 if cornered else 0.0
        return grid.transform.indexToWorld(tuple(c + offset for c in ijk))

    def check_values(self, grid, up, cornered, expected, tolerance=2e-6):
        """Every active value equals expected(point in the asset's frame)."""
        count = 0
        for item in grid.iterOnValues():
            self.assertEqual(item.count, 1, "no active tiles: Blender does not draw them")
            point = turn_back(self.world(grid, item.min, cornered), up)
            for axis in range(3):
                self.assertLessEqual(abs(point[axis]), SIZE[axis] / 2 + 1e-6)
            value = item.value if isinstance(item.value, tuple) else (item.value,)
            for got, want in zip(value, expected(point)):
                self.assertAlmostEqual(got, want, delta=tolerance * max(1, abs(want)))
            count += 1
        # The box holds this many samples, whichever way it is turned.
        expected_count = 1
        for axis in range(3):
            expected_count *= SIZE[axis] / 0.11
        self.assertAlmostEqual(count / expected_count, 1, delta=0.12)

    def test_every_target(self):
        for target, (velocity, vector_class, up, cornered) in TARGETS.items():
            with self.subTest(target=target):
                path, report = self.bake("--target", target)
                grids = {g.name: g for g in vdb.readAllGridMetadata(path)}
                self.assertEqual(set(grids), {"height", "slope", velocity, "mass"})
                self.assertEqual({g["name"] for g in report["files"][0]["grids"]}, set(grids))
                height, slope = vdb.read(path, "height"), vdb.read(path, "slope")
                flow, mass = vdb.read(path, velocity), vdb.read(path, "mass")
                self.assertEqual([g.valueTypeName for g in (height, slope, flow, mass)],
                                 ["float", "vec3s", "vec3s", "float"])
                self.assertEqual(slope.metadata["vector_type"], "covariant")
                self.assertEqual(flow.metadata["vector_type"], "contravariant relative")
                self.assertEqual(flow.gridClass, vector_class)
                self.assertEqual(mass.gridClass, "fog volume")
                for grid in (height, slope, flow, mass):
                    self.assertTrue(grid.metadata["creator"].startswith("OctetVDB"))
                    self.assertEqual(grid.transform.voxelSize(), (0.11, 0.11, 0.11))
                    self.assertFalse(grid.saveFloatAsHalf)
                corner = -0.055 if cornered else 0.0
                for axis in range(3):
                    self.assertAlmostEqual(flow.transform.indexToWorld((0, 0, 0))[axis], corner)
                self.check_values(height, up, cornered, lambda p: (linear(p),))
                self.check_values(slope, up, cornered, lambda p: turn(SLOPE, up))
                self.check_values(flow, up, cornered, lambda p: turn(FLOW, up))
                densities = [item.value for item in mass.iterOnValues()]
                self.assertAlmostEqual(sum(densities) / len(densities), DENSITY,
                                       delta=0.005 * DENSITY)

    def test_constant_density_on_the_lattice(self):
        """An octahedron of lattice cells: flat walls, sharp edges."""
        cage = oa.lattice(lambda p: sum(map(abs, p)) <= 2, 2)
        # Of the volumes, that of an octahedron is four times that of a tetrahedron.
        masses = {**{t: DENSITY / 3 for t in cage.tetrahedra},
                  **{o: DENSITY * 4 / 3 for o in cage.octahedra}}
        asset = os.path.join(self.folder.name, "lattice.octet.json")
        oa.write(asset, "lattice", cage, [oa.form("mass", 3, "kg", masses)])
        for options in ([], ["--reconstruction", "whitney"], ["--target", "houdini"]):
            out = os.path.join(self.folder.name, "lattice.vdb")
            subprocess.run([OCTETVDB, "bake", asset, "-o", out, "--voxel-size", "0.11", *options],
                           check=True, capture_output=True)
            grid = vdb.read(out, "mass")
            values = [item.value for item in grid.iterOnValues()]
            # All index points with |i| + |j| + |k| <= 2 / 0.11.
            n = int(2 / 0.11)
            self.assertEqual(len(values), (2 * n + 1) * (2 * n * n + 2 * n + 3) // 3)
            for value in values:
                self.assertAlmostEqual(value, DENSITY, delta=2e-6)

    def test_frames_equal_separate_bakes(self):
        """Each frame of an animated asset, as an asset of its own, makes the same grids."""
        with open(os.path.join(os.path.dirname(oa.__file__), "animated",
                               "animated.octet.json")) as file:
            animated = json.load(file)

        def bake(document, name):
            asset = os.path.join(self.folder.name, name + ".octet.json")
            with open(asset, "w") as file:
                json.dump(document, file)
            subprocess.run([OCTETVDB, "bake", asset, "-o", asset + ".vdb", "--resolution", "24"],
                           check=True, capture_output=True)
            return asset

        whole = bake(animated, "animated")
        frames = sorted({f for form in animated["forms"] for f in form.get("frames", {})}, key=int)
        self.assertGreaterEqual(len(frames), 24)
        for frame in (frames[0], frames[7], frames[-1]):
            still = json.loads(json.dumps(animated))
            for form in still["forms"]:
                if "frames" in form:
                    form["values"] = form.pop("frames")[frame]
            alone = bake(still, "still") + ".vdb"
            together = f"{whole}.{int(frame):04}.vdb"
            for grid in vdb.readAllGridMetadata(alone):
                a, b = (vdb.read(path, grid.name) for path in (alone, together))
                self.assertGreater(a.activeVoxelCount(), 1000)
                self.assertEqual([(i.min, i.value) for i in a.iterOnValues()],
                                 [(i.min, i.value) for i in b.iterOnValues()])

    def test_half(self):
        path, _ = self.bake("--half", "--form", "flow")
        grid = vdb.read(path, "flow")
        self.assertTrue(grid.saveFloatAsHalf)
        self.assertTrue(vdb.readGridMetadata(path, "flow").metadata["is_saved_as_half_float"])
        self.check_values(grid, "Z", False, lambda p: FLOW, tolerance=1e-3)

    def test_staggered(self):
        path, _ = self.bake("--grid", "staggered", "--form", "flow")
        grid = vdb.read(path, "flow")
        self.assertEqual(grid.gridClass, "staggered")
        for item in grid.iterOnValues():
            for axis in range(3):
                index = list(item.min)
                index[axis] -= 0.5
                point = grid.transform.indexToWorld(tuple(index))
                inside = all(abs(point[k]) < SIZE[k] / 2 - 1e-9 for k in range(3))
                outside = any(abs(point[k]) > SIZE[k] / 2 + 1e-6 for k in range(3))
                if inside:
                    self.assertAlmostEqual(item.value[axis], FLOW[axis], delta=1e-6)
                elif outside:
                    self.assertEqual(item.value[axis], 0)

    def test_derivative(self):
        path, _ = self.bake("--d", "--form", "height")
        grid = vdb.read(path, "height")
        self.assertEqual(grid.metadata["vector_type"], "covariant")
        self.check_values(grid, "Z", False, lambda p: SLOPE)

    def test_whitney(self):
        path, _ = self.bake("--reconstruction", "whitney")
        self.check_values(vdb.read(path, "height"), "Z", False, lambda p: (linear(p),))
        # The linear rule in an octahedron keeps constant fluxes only if it is affine.
        self.check_values(vdb.read(path, "flow"), "Z", False, lambda p: FLOW, tolerance=0.3)

    def test_vdb_print_agrees(self):
        path, report = self.bake("--target", "renderman", "--form", "flow")
        text = subprocess.run(["vdb_print", "-l", path], capture_output=True, text=True).stdout
        self.assertIn("Name: velocity", text)
        self.assertIn("Tree_vec3s_5_4_3", text)
        self.assertIn("class: fog volume", text)
        self.assertIn("vector_type: contravariant relative", text)
        self.assertIn("voxel size: 0.11", text)
        voxels = report["files"][0]["grids"][0]["active_voxels"]
        self.assertIn(f"Number of active voxels:       {voxels:,}", text)
        self.assertIn("Number of active tiles:        0", text)


if __name__ == "__main__":
    unittest.main()
