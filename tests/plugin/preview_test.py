#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""octetvdb preview from outside: grids written by OpenVDB's own Python module, through any transform,
and control assets of known fields, drawn to OpenEXR and read back by OpenImageIO's oiiotool; what
is refused; what a cancelled run leaves. Arguments: the octetvdb command.
"""
import math
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import pyopenvdb as vdb

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples"))
import octet_asset as oa

OCTETVDB = sys.argv.pop(1)
SIZE = (2.0, 3.0, 1.5)
FLOW = (0.25, -1.5, 0.75)
BAD_INPUT, FAILED, INTERRUPTED = 2, 1, 130


class Image:
    """A part of an OpenEXR file as oiiotool sees it."""

    def __init__(self, path, part=0):
        info = subprocess.run(["oiiotool", "--info", "-v", "-a", path], capture_output=True, text=True,
                              check=True).stdout
        parts = re.split(r"\n subimage +\d+:", info)
        text = parts[part + 1] if len(parts) > 1 else info
        self.parts = max(1, len(parts) - 1)
        self.channels = re.search(r"channel list: (.*)", text)[1].split(", ")
        self.width, self.height = map(int, re.search(r"(\d+) x +(\d+)", text).groups())
        self.attributes = {name: value.strip('"')
                           for name, value in re.findall(r"octet\.(\w+): (.*)", text)}
        one = path + ".part.exr"
        subprocess.run(["oiiotool", path, "--subimage", str(part), "-o", one], check=True)
        dump = subprocess.run(["oiiotool", "--dumpdata", one], capture_output=True, text=True,
                              check=True).stdout
        os.remove(one)
        self.pixels = {}
        for line in re.findall(r"Pixel \((\d+), (\d+)\): (.*)", dump):
            values = [float(v) for v in line[2].split()]
            self.pixels[int(line[0]), int(line[1])] = dict(zip(self.channels, values))

    def vector(self, name):
        return [float(x) for x in self.attributes[name].split(", ")]

    def point(self, x, y):
        """World position of a pixel's centre, by the header alone."""
        low, high = self.vector("worldMin"), self.vector("worldMax")
        spacing = float(self.attributes["spacing"])
        result = {self.attributes["axis"]: float(self.attributes["position"])}
        right, up = self.attributes["right"], self.attributes["up"]
        result[right] = low["xyz".index(right)] + (x + 0.5) * spacing
        result[up] = high["xyz".index(up)] - (y + 0.5) * spacing
        return tuple(result[k] for k in "xyz")


def linear(p):
    """A linear vector field of world positions: trilinear sampling keeps it."""
    return (1 + 2 * p[0] - p[1], 3 - p[2], 0.5 * p[0] + p[1] + p[2])


def matrix(scale, angle, offset):
    """Row vectors times this: scaled, turned around z, moved."""
    c, s = math.cos(angle), math.sin(angle)
    return [[scale[0] * c, scale[0] * s, 0, 0], [-scale[1] * s, scale[1] * c, 0, 0],
            [0, 0, scale[2], 0], [*offset, 1]]


class Preview(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def run_preview(self, *arguments):
        return subprocess.run([OCTETVDB, "--progress", "none", "preview", *arguments], capture_output=True, text=True)

    def preview(self, source, *options, out="out.exr"):
        result = self.run_preview(source, "-o", self.path(out), *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout + result.stderr, "")
        return self.path(out)

    def refuse(self, code, words, *arguments):
        before = sorted(os.listdir(self.folder.name))
        result = self.run_preview(*arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(sorted(os.listdir(self.folder.name)), before)

    def asset(self):
        cage = oa.box((2, 3, 2), SIZE)
        heights = {(v,): 4 + p[0] - 2 * p[1] for v, p in enumerate(cage.vertices)}
        fluxes = {f: cage.flux(lambda p: FLOW, f) for f in cage.facets}
        volume = SIZE[0] * SIZE[1] * SIZE[2] / len(cage.tetrahedra)
        path = self.path("asset.octet.json")
        oa.write(path, "constants", cage,
                 [oa.form("height", 0, "m", heights), oa.form("flow", 2, "m/s", fluxes),
                  oa.form("mass", 3, "kg", {t: volume for t in cage.tetrahedra})])
        return path

    def grid_file(self, grids, name="grid.vdb"):
        vdb.write(self.path(name), grids=grids)
        return self.path(name)

    def block(self, kind, size, transform, value, name="wind"):
        """A block of active voxels from 0 to size - 1."""
        grid = kind()
        grid.name = name
        grid.transform = transform
        accessor = grid.getAccessor()
        for i in range(size[0]):
            for j in range(size[1]):
                for k in range(size[2]):
                    accessor.setValueOn((i, j, k), value((i, j, k)))
        return grid

    # ---- grids ---------------------------------------------------------------------------------

    def check_linear(self, path, transform, size, channels, expected, half=0.0):
        """Where all voxels around are active, the field's value; A tells the block's cubes.
        half: the field's components lie in this part of a voxel around the centre."""
        image = Image(path)
        checked = outside = 0
        for (x, y), pixel in image.pixels.items():
            p = image.point(x, y)
            index = transform.worldToIndex(p)
            depth = min(min(i + 0.5, n - 0.5 - i) for i, n in zip(index, size))
            if abs(depth) < 1e-3 + half:
                continue
            self.assertEqual(pixel["A"], 1 if depth > 0 else 0, (p, index))
            if depth < 0:
                outside += 1
                self.assertTrue(all(pixel[c] == 0 for c in channels))
            elif depth >= 0.5 + half:
                checked += 1
                for c, want in zip(channels, expected(p)):
                    self.assertAlmostEqual(pixel[c], want, delta=1e-4)
        self.assertGreater(checked, 100)
        self.assertGreater(outside, 20)

    def test_transforms_are_respected(self):
        size = (9, 12, 7)
        channels = ("velocity.X", "velocity.Y", "velocity.Z")
        for place, m in enumerate((matrix((0.2, 0.2, 0.2), 0, (-1, 0.5, 3)),
                                   matrix((0.1, 0.4, 0.25), 0.6, (1, -2, 0.5)),
                                   matrix((-0.3, 0.2, 0.2), -1.1, (0, 0, 0)))):
            transform = vdb.createLinearTransform(m)
            grid = self.block(vdb.Vec3SGrid, size, transform,
                              lambda ijk: linear(transform.indexToWorld(ijk)))
            # One voxel far away leaves room around the block.
            grid.getAccessor().setValueOn((13, 15, 9), (0, 0, 0))
            path = self.grid_file([grid])
            for axis in "xyz":
                with self.subTest(transform=place, axis=axis):
                    centre = transform.indexToWorld((4.0, 5.5, 3.0))["xyz".index(axis)]
                    out = self.preview(path, "--slice", f"{axis}={centre + 0.01}", "--width", "60",
                                       "--height", "60")
                    self.check_linear(out, transform, size, channels, linear)

    def test_staggered_components_lie_on_faces(self):
        size = (10, 10, 10)
        transform = vdb.createLinearTransform(matrix((0.25, 0.25, 0.25), 0.4, (1, 2, 3)))

        def value(ijk):
            return tuple(linear(transform.indexToWorld([i - (0.5 if k == c else 0)
                                                        for k, i in enumerate(ijk)]))[c]
                         for c in range(3))
        grid = self.block(vdb.Vec3SGrid, size, transform, value)
        grid.gridClass = "staggered"
        grid.getAccessor().setValueOn((14, 14, 14), (0, 0, 0))
        path = self.grid_file([grid])
        out = self.preview(path, "--slice", "z=4.2", "--rgb", "--width", "60", "--height", "60")
        self.check_linear(out, transform, size, "RGB", linear, half=0.5)

    def test_scalars_tiles_and_choice_of_grid(self):
        transform = vdb.createLinearTransform(0.5)
        density = self.block(vdb.FloatGrid, (4, 4, 4), transform, lambda ijk: ijk[0], "density")
        tiles = vdb.FloatGrid()
        tiles.name = "tiles"
        tiles.fill((0, 0, 0), (31, 31, 31), 7.0)
        wind = self.block(vdb.Vec3SGrid, (4, 4, 4), transform, lambda ijk: (1, 2, 3))
        mask = self.block(vdb.BoolGrid, (4, 4, 4), transform, lambda ijk: True, "mask")
        path = self.grid_file([mask, density, tiles, wind])
        image = Image(self.preview(path, "--width", "16", "--height", "16"))
        self.assertEqual(image.attributes["form"], "wind")
        self.assertEqual(set(image.channels), {"velocity.X", "velocity.Y", "velocity.Z", "A"})
        image = Image(self.preview(path, "--form", "density", "--width", "16", "--height", "16"))
        self.assertEqual(set(image.channels), {"density", "A"})
        self.assertAlmostEqual(image.pixels[6, 8]["density"], (6 + 0.5) / 4 - 0.5)
        image = Image(self.preview(path, "--form", "tiles", "--width", "16", "--height", "16"))
        self.assertTrue(all(p["tiles"] == 7 and p["A"] == 1 for p in image.pixels.values()))
        self.refuse(BAD_INPUT, ["mask", "bool"], path, "-o", self.path("a.png"), "--form", "mask")
        self.refuse(BAD_INPUT, ["\"smoke\"", "it has mask, density, tiles, wind"], path, "-o",
                    self.path("a.png"), "--form", "smoke")

    def test_grids_that_hold_nothing_to_draw(self):
        transform = vdb.createLinearTransform(1.0)
        empty = vdb.Vec3SGrid()
        empty.name = "empty"
        broken = self.block(vdb.Vec3SGrid, (3, 3, 3), transform,
                            lambda ijk: (0, math.nan if ijk == (1, 2, 0) else 1, 0), "broken")
        infinite = self.block(vdb.FloatGrid, (3, 3, 3), transform,
                              lambda ijk: math.inf if ijk == (2, 2, 2) else 1, "infinite")
        mask = self.block(vdb.BoolGrid, (3, 3, 3), transform, lambda ijk: True, "mask")
        out = ("-o", self.path("a.png"))
        path = self.grid_file([empty, broken, infinite])
        self.refuse(BAD_INPUT, [path, "empty", "no active voxel"], path, *out, "--form", "empty")
        self.refuse(BAD_INPUT, [path, "broken", "[1, 2, 0]", "not finite"], path, *out, "--form",
                    "broken")
        self.refuse(BAD_INPUT, ["infinite", "[2, 2, 2]"], path, *out, "--form", "infinite")
        path = self.grid_file([mask], "mask.vdb")
        self.refuse(BAD_INPUT, [path, "no grid of type"], path, *out)
        with open(self.path("text.vdb"), "w") as file:
            file.write("not a grid")
        self.refuse(BAD_INPUT, ["text.vdb"], self.path("text.vdb"), *out)
        self.refuse(BAD_INPUT, ["missing.vdb"], self.path("missing.vdb"), *out)
        # A file cut anywhere is noticed, and does not claim what memory there is.
        with open(self.grid_file([infinite, broken]), "rb") as file:
            whole = file.read()
        for length in [60, 100, 200, *range(len(whole) // 8, len(whole) - 1, len(whole) // 8)]:
            with open(self.path("cut.vdb"), "wb") as file:
                file.write(whole[:length])
            self.refuse(BAD_INPUT, ["cut.vdb", "not a readable .vdb"], self.path("cut.vdb"), *out)

    def test_one_voxel_is_a_domain(self):
        for size in (1e-4, 1e6):
            grid = self.block(vdb.Vec3SGrid, (1, 1, 1), vdb.createLinearTransform(size),
                              lambda ijk: (1, 2, 3))
            path = self.grid_file([grid])
            image = Image(self.preview(path, "--width", "16", "--height", "16"))
            self.assertTrue(all(p["velocity.Y"] == 2 for p in image.pixels.values()))
            for options in ((), ("--style", "lic"), ("--view", "3d")):
                self.preview(path, *options, "--width", "320", "--height", "180", out="out.png")

    # ---- control assets ------------------------------------------------------------------------

    def test_constants_at_every_level(self):
        path = self.asset()
        # Whitney: the linear rule in an octahedron keeps constant fluxes only where it is affine.
        for reconstruction, most, tolerance in (("limit", 4, 1e-6), ("whitney", 1, 1e-6),
                                                ("whitney", 2, 0.1)):
            for levels in range(most - 1 if tolerance > 1e-3 else 0, most):
                out = self.preview(path, "--levels", str(levels), "--reconstruction", reconstruction,
                                   "--slice", "y=0.2", "--width", "24", "--height", "24", "--rgb")
                image = Image(out)
                self.assertEqual((image.width, image.height), (24, 18))
                for (x, y), pixel in image.pixels.items():
                    self.assertEqual(pixel["A"], 1)
                    for c, want in zip("RGB", FLOW):
                        self.assertAlmostEqual(pixel[c], want, delta=tolerance)

    def test_every_degree(self):
        path = self.asset()
        image = Image(self.preview(path, "--form", "height", "--width", "24", "--height", "24"))
        self.assertEqual(image.attributes["degree"], "0")
        for (x, y), pixel in image.pixels.items():
            p = image.point(x, y)
            self.assertAlmostEqual(pixel["height"], 4 + p[0] - 2 * p[1], delta=1e-5)
        image = Image(self.preview(path, "--form", "mass", "--levels", "2", "--width", "24", "--height",
                                   "24"))
        # Masses are kept, but smoothing changes the cells' volumes a little differently.
        densities = [pixel["mass"] for pixel in image.pixels.values()]
        self.assertAlmostEqual(sum(densities) / len(densities), 1, delta=0.05)
        self.assertTrue(all(abs(x - 1) < 0.3 for x in densities))
        for form in ("height", "mass"):
            self.preview(path, "--form", form, "--levels", "2", "--view", "3d", "--width", "160",
                         "--height", "90", out="out.png")

    def test_stack_and_atlas(self):
        path = self.asset()
        stack = self.preview(path, "--form", "height", "--slice", "x", "--stack", "3", "--width", "16",
                             "--height", "16")
        atlas = Image(self.preview(path, "--form", "height", "--slice", "x", "--stack", "3", "--width",
                                   "16", "--height", "16", "--atlas", out="atlas.exr"))
        columns = int(atlas.attributes["atlasColumns"])
        for k in range(3):
            image = Image(stack, k)
            self.assertEqual(image.parts, 3)
            self.assertAlmostEqual(float(image.attributes["position"]), (k - 1) * SIZE[0] / 3, delta=1e-6)
            for (x, y), pixel in image.pixels.items():
                p = image.point(x, y)
                self.assertAlmostEqual(pixel["height"], 4 + p[0] - 2 * p[1], delta=1e-5)
                at = (k % columns * image.width + x, k // columns * image.height + y)
                self.assertEqual(atlas.pixels[at], pixel)

    def test_3d_view_as_light(self):
        image = Image(self.preview(self.asset(), "--view", "3d", "--levels", "2", "--width", "64",
                                   "--height", "48"))
        self.assertEqual(image.channels, ["R", "G", "B", "A"])
        self.assertEqual(image.pixels[0, 0], dict.fromkeys("RGBA", 0.0))
        self.assertGreater(max(p["A"] for p in image.pixels.values()), 0.5)

    def test_threads_give_the_same_bytes(self):
        path = self.asset()
        for name, options in (("a.png", ("--view", "3d")), ("a.exr", ("--stack", "2"))):
            results = []
            for threads in ("1", "2", "5"):
                out = self.preview(path, "--levels", "2", "--width", "160", "--height", "90",
                                   "--threads", threads, *options, out=name)
                with open(out, "rb") as file:
                    results.append(file.read())
            self.assertEqual(results[0], results[1])
            self.assertEqual(results[0], results[2])

    # ---- what is refused -----------------------------------------------------------------------

    def test_bad_requests(self):
        path = self.asset()
        png, exr = ("-o", self.path("a.png")), ("-o", self.path("a.exr"))
        self.refuse(BAD_INPUT, ["slice z", "-0.75 to 0.75"], path, *png, "--slice", "z=0.76")
        self.refuse(BAD_INPUT, ["--slice", "w"], path, *png, "--slice", "w")
        self.refuse(BAD_INPUT, ["--slice", "nan"], path, *png, "--slice", "z=nan")
        self.refuse(BAD_INPUT, ["\"smoke\"", "flow"], path, *png, "--form", "smoke")
        self.refuse(BAD_INPUT, ["scalar", "height"], path, *png, "--form", "height", "--style", "lic")
        self.refuse(BAD_INPUT, ["scalar"], path, *png, "--form", "height", "--quantity", "curl")
        self.refuse(BAD_INPUT, ["levels"], path, *png, "--levels", "12")
        self.refuse(BAD_INPUT, ["levels"], path, *png, "--levels", "-1")
        self.refuse(BAD_INPUT, ["--frame"], path, *png, "--frame", "3")
        self.refuse(BAD_INPUT, ["--output", ".jpg"], path, "-o", self.path("a.jpg"))
        self.refuse(BAD_INPUT, ["--camera"], path, *png, "--view", "3d", "--camera", "10")
        self.refuse(BAD_INPUT, ["--camera"], path, *png, "--view", "3d", "--camera", "0,91")
        self.refuse(BAD_INPUT, ["--range"], path, *png, "--range", "3,1")
        self.refuse(BAD_INPUT, ["--stack"], path, *png, "--stack", "3")
        self.refuse(BAD_INPUT, ["--style"], path, *exr, "--style", "lic")
        self.refuse(BAD_INPUT, ["--camera"], path, *png, "--camera", "0,0")
        self.refuse(BAD_INPUT, ["--slice"], path, *png, "--view", "3d", "--slice", "x")
        self.refuse(BAD_INPUT, ["stack"], path, *exr, "--slice", "x=0", "--stack", "3")
        self.refuse(BAD_INPUT, ["layer"], path, *exr, "--layer", "a.b")
        self.refuse(FAILED, ["missing"], path, "-o", self.path("missing/a.png"))
        self.refuse(FAILED, ["missing"], path, "-o", self.path("missing/a.exr"))
        self.refuse(BAD_INPUT, ["--output"], path, "-o", path)

    def test_an_asset_without_forms_shows_its_shape(self):
        path = self.path("bare.octet.json")
        oa.write(path, "bare", oa.box((1, 1, 1), SIZE), [])
        self.preview(path, "--view", "3d", "--width", "160", "--height", "90", out="out.png")
        self.refuse(BAD_INPUT, ["no form"], path, "-o", self.path("a.png"))

    def test_interrupted_leaves_nothing(self):
        path = self.asset()
        before = sorted(os.listdir(self.folder.name))
        for options in (("a.png", "--view", "3d", "--width", "16000", "--height", "9000"),
                        ("a.exr", "--stack", "1000", "--width", "2000", "--height", "2000")):
            process = subprocess.Popen([OCTETVDB, "--progress", "none", "preview", path, "-o", self.path(options[0]),
                                        *options[1:]], stderr=subprocess.PIPE)
            time.sleep(1.5)
            self.assertIsNone(process.poll(), "work that long should not be done")
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=30)
            self.assertEqual(process.returncode, INTERRUPTED)
            self.assertEqual(sorted(os.listdir(self.folder.name)), before)

    def test_png_has_the_size_asked_for(self):
        out = self.preview(self.asset(), "--width", "321", "--height", "200", out="out.png")
        with open(out, "rb") as file:
            self.assertEqual(struct.unpack(">II", file.read(24)[16:]), (321, 200))


if __name__ == "__main__":
    unittest.main()
