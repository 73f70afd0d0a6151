#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""octetvdb fill and add: cages from boxes, .obj, .stl and .vdb; bad input ends with exit code 2, one
line, and nothing written. Arguments: the octetvdb command.
"""
import json
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import numpy
import pyopenvdb

OCTETVDB = os.path.abspath(sys.argv.pop(1))
BUNNY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples/cages/bunny.py")


def ball(n=24, radius=1.0):
    """Vertices and triangles of a ball."""
    vertices, triangles, around = [(0, 0, radius)], [], 2 * n
    for i in range(1, n):
        for j in range(around):
            u, v = math.pi * i / n, math.pi * j / n
            vertices.append((radius * math.sin(u) * math.cos(v), radius * math.sin(u) * math.sin(v),
                             radius * math.cos(u)))
    vertices.append((0, 0, -radius))
    last = len(vertices) - 1
    for j in range(around):
        k = (j + 1) % around
        triangles += [(0, 1 + j, 1 + k), (last, last - around + k, last - around + j)]
        for i in range(n - 2):
            a, b = 1 + i * around + j, 1 + i * around + k
            triangles += [(a, a + around, b), (b, a + around, b + around)]
    return vertices, triangles


def obj(vertices, triangles):
    return "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices) + "".join(
        f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles)


def binary_stl(vertices, triangles):
    data = bytes(80) + struct.pack("<I", len(triangles))
    for t in triangles:
        data += struct.pack("<12fH", 0, 0, 0, *(x for v in t for x in vertices[v]), 0)
    return data


def text_stl(vertices, triangles):
    text = "solid ball\n"
    for t in triangles:
        text += "facet normal 0 0 0\nouter loop\n"
        text += "".join("vertex %.9g %.9g %.9g\n" % vertices[v] for v in t)
        text += "endloop\nendfacet\n"
    return text + "endsolid ball\n"


class CommandTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name, content=None):
        path = os.path.join(self.folder.name, name)
        if content is not None:
            with open(path, "wb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
        return path

    def run_it(self, *arguments):
        return subprocess.run([OCTETVDB, *arguments], capture_output=True, text=True, check=False)

    def succeed(self, *arguments):
        done = self.run_it(*arguments, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def refuse(self, reason, *arguments):
        out = self.path("refused.octet.json")
        done = self.run_it(*arguments, "-o", out)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(reason, done.stderr)
        self.assertFalse(os.path.exists(out))


class Fill(CommandTest):
    def check(self, summary, volume, spacing):
        """What every fill promises, as info tells it too."""
        types = summary["vertex_types"]
        self.assertLessEqual(set(types), {"R", "B3"})
        self.assertEqual(summary["quality"]["touching_vertices"], 0)
        self.assertEqual(summary["quality"]["touching_edges"], 0)
        self.assertAlmostEqual(summary["volume"], volume, delta=spacing * volume)
        info = self.succeed("info", summary["output"])
        for key in ("vertices", "tetrahedra", "octahedra", "quality", "vertex_types"):
            self.assertEqual(info[key], summary[key], key)

    def test_box_has_twelve_creases_and_eight_corners(self):
        for name in ("box.octet.json", "box.octet"):
            summary = self.succeed("fill", "--box", "-1", "0", "0", "1", "1", "3", "--spacing",
                                   "0.4", "-o", self.path(name))
            self.check(summary, 6, 1e-13)
            self.assertEqual(summary["corners"], 8)

    def test_obj_and_stl_of_one_body_make_the_same_cage(self):
        mesh = ball()
        cages = []
        for name, content in (("a.obj", obj(*mesh)), ("a.stl", text_stl(*mesh))):
            summary = self.succeed("fill", self.path(name, content), "--spacing", "0.3",
                                   "--fit-boundary", "-o", self.path(name + ".octet.json"))
            self.check(summary, 4.19, 0.3)
            self.assertEqual(summary["fill"]["fit"]["vertices_off_surface"], 0)
            with open(summary["output"]) as file:
                cages.append(json.load(file))
        self.assertEqual(cages[0]["octahedra"], cages[1]["octahedra"])
        summary = self.succeed("fill", self.path("b.stl", binary_stl(*mesh)), "--spacing", "0.3",
                               "-o", self.path("b.octet"))
        self.check(summary, 4.19, 0.3)

    def test_fit_makes_creases_of_sharp_edges(self):
        corners = [(k & 1, k >> 1 & 1, k >> 2) for k in range(8)]
        quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
        cube = self.path("cube.obj", obj(corners, [t for a, b, c, d in quads
                                                   for t in ((a, b, c), (a, c, d))]))
        fill = ("fill", cube, "--spacing", "0.25", "--fit-boundary", "-o")
        summary = self.succeed(*fill, self.path("cube.octet.json"))
        self.check(summary, 1, 1e-9)
        self.assertAlmostEqual(summary["fill"]["crease_length"], 12, delta=1e-9)
        self.assertEqual(summary["corners"], 8)
        summary = self.succeed(*fill, self.path("round.octet.json"), "--sharp-angle", "91")
        self.assertEqual((summary["creases"], summary["fill"]["sharp_length"]), (0, 0))

    def test_level_set_and_fog(self):
        bunny = self.path("bunny.vdb")
        subprocess.run([sys.executable, BUNNY, bunny], check=True)
        summary = self.succeed("fill", bunny, "--spacing", "0.1", "--fit-boundary", "-o",
                               self.path("bunny.octet"))
        self.check(summary, summary["fill"]["body_volume"], 0.1)
        fog = pyopenvdb.FloatGrid(0.0)
        fog.name = "density"
        fog.gridClass = pyopenvdb.GridClass.FOG_VOLUME
        index = numpy.indices((48, 48, 48)) - 23.5
        radius = numpy.sqrt((index ** 2).sum(axis=0))
        fog.copyFromArray(numpy.clip((20 - radius) / 4, 0, 1).astype(numpy.float32))
        path = self.path("fog.vdb")
        pyopenvdb.write(path, grids=[fog])
        half = self.succeed("fill", path, "--spacing", "5", "-o", self.path("half.octet"))
        self.check(half, 4 / 3 * math.pi * 18 ** 3, 0.1)
        most = self.succeed("fill", path, "--spacing", "5", "--isovalue", "0.1", "-o",
                            self.path("most.octet"))
        self.assertGreater(most["volume"], half["volume"])
        self.refuse("the file has density", "fill", path, "--grid", "heat", "--spacing", "5")
        self.refuse("no surface", "fill", path, "--isovalue", "7", "--spacing", "5")

    def test_refuses_bad_input(self):
        vertices, triangles = ball()
        good = self.path("ball.obj", obj(vertices, triangles))
        self.refuse("too coarse", "fill", good, "--spacing", "4")
        self.refuse("too fine", "fill", good, "--spacing", "1e-5")
        self.refuse("not a positive number", "fill", good, "--spacing", "-1")
        self.refuse("not a positive number", "fill", good, "--spacing", "nan")
        self.refuse("either INPUT or --box", "fill", "--spacing", "1")
        self.refuse("is empty", "fill", "--box", "0", "0", "0", "1", "1", "0", "--spacing", "1")
        fill = lambda name, content: ("fill", self.path(name, content), "--spacing", "0.3")
        self.refuse("not closed", *fill("open.obj", obj(vertices, triangles[1:])))
        self.refuse("", *fill("empty.obj", ""))
        self.refuse("", *fill("words.obj", "this is no mesh\n"))
        self.refuse("", *fill("points.obj", "v 0 0 0\nv 1 0 0\n"))
        self.refuse("", *fill("zeros.stl", bytes(500)))
        bad = list(vertices)
        bad[7] = (math.nan, 0, 0)
        self.refuse("", *fill("nan.obj", obj(bad, triangles)))
        self.refuse("finite", *fill("nan.stl", binary_stl(bad, triangles)))
        whole = binary_stl(vertices, triangles)
        for size in (10, 84, 100, len(whole) // 2, len(whole) - 1):
            self.refuse("", *fill("cut.stl", whole[:size]))
        self.refuse("cut off", *fill("cut.stl", text_stl(vertices, triangles)[:3000]))
        self.refuse("none of .obj", *fill("mesh.ply", "ply\n"))
        self.refuse("cannot be read", *fill("cut.vdb", b"nothing"))
        self.refuse("cannot be read", "fill", self.path("absent.obj"), "--spacing", "1")
        crossing = [(x + 1, y, z) for x, y, z in vertices]
        both = obj(vertices + crossing, triangles +
                   [tuple(v + len(vertices) for v in t) for t in triangles])
        self.refuse("intersects itself", *fill("cross.obj", both))


class Tetrahedra(CommandTest):
    """--cells tetrahedra, where octetvdb-gmsh was built."""

    def setUp(self):
        super().setUp()
        done = self.fill("--box", "0", "0", "0", "1", "1", "1", spacing="1")
        if "octetvdb-gmsh: is not installed" in done.stderr:
            self.skipTest("without octetvdb-gmsh")
        self.assertEqual(done.returncode, 0, done.stderr)

    def fill(self, *arguments, spacing="0.3", name="cage.octet.json"):
        return self.run_it("fill", *arguments, "--cells", "tetrahedra", "--spacing", spacing, "-o",
                           self.path(name), "--json")

    def check(self, done):
        """The summary, which info tells too; nothing but tetrahedra."""
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads(done.stdout)
        info = self.succeed("info", summary["output"])
        for key in ("vertices", "tetrahedra", "creases", "corners", "quality", "volume"):
            self.assertEqual(info[key], summary[key], key)
        self.assertEqual(summary["octahedra"], 0)
        self.assertEqual(summary["quality"]["touching_vertices"], 0)
        self.assertEqual(summary["quality"]["touching_edges"], 0)
        self.assertGreater(summary["quality"]["dihedral_angles"][0], 5)
        return summary

    def test_box_has_its_edges(self):
        for name in ("box.octet.json", "box.octet"):
            summary = self.check(self.fill("--box", "-1", "0", "0", "1", "1", "3", "--name", "room",
                                           "--up-axis", "y", name=name))
            self.assertAlmostEqual(summary["volume"], 6, delta=1e-11)
            self.assertEqual(summary["corners"], 8)
            self.assertAlmostEqual(summary["fill"]["crease_length"], 24, delta=1e-11)
            self.assertEqual(summary["fill"]["boundary"], "remeshed")
            info = self.succeed("info", summary["output"])
            self.assertEqual((info["name"], info["up_axis"]), ("room", "Y"))

    def test_obj_stl_and_level_set(self):
        mesh = ball()
        for name, content in (("a.obj", obj(*mesh)), ("b.stl", binary_stl(*mesh))):
            summary = self.check(self.fill(self.path(name, content)))
            self.assertAlmostEqual(summary["volume"], 4.19, delta=0.2)
            self.assertEqual(summary["creases"], 0)
        bunny = self.path("bunny.vdb")
        subprocess.run([sys.executable, BUNNY, bunny], check=True)
        summary = self.check(self.fill(bunny, spacing="0.15"))
        body = summary["fill"]["body_volume"]
        self.assertAlmostEqual(summary["volume"], body, delta=0.05 * body)

    def test_cavities_stay_empty(self):
        vertices, triangles = ball()
        inner = [(x / 2, y / 2, z / 2) for x, y, z in vertices]
        both = obj(vertices + inner, triangles +
                   [tuple(v + len(vertices) for v in t) for t in triangles])
        summary = self.check(self.fill(self.path("shell.obj", both), spacing="0.2"))
        self.assertEqual((summary["fill"]["bodies"], summary["fill"]["cavities"]), (1, 1))
        self.assertAlmostEqual(summary["volume"], 4.19 * 7 / 8, delta=0.1)

    def test_options(self):
        coarse = self.path("ball.obj", obj(*ball(8)))
        self.assertEqual(self.check(self.fill(coarse, spacing="0.4"))["fill"]["boundary"], "remeshed")
        summary = self.check(self.fill(coarse, "--keep-triangles", spacing="0.4"))
        self.assertEqual(summary["boundary_facets"], summary["fill"]["surface_triangles"])
        box = ("--box", "0", "0", "0", "1", "1", "1")
        self.assertEqual(self.check(self.fill(*box, "--sharp-angle", "91"))["creases"], 0)
        self.assertEqual(self.check(self.fill(*box, "--sharp-angle", "89"))["corners"], 8)

    def test_refuses_bad_input(self):
        vertices, triangles = ball()
        good = self.path("ball.obj", obj(vertices, triangles))
        cells = ("--cells", "tetrahedra")
        self.refuse("--spacing: is too coarse", "fill", good, *cells, "--spacing", "4")
        self.refuse("--spacing: is too fine", "fill", good, *cells, "--spacing", "1e-5")
        self.refuse("not a positive number", "fill", good, *cells, "--spacing", "nan")
        self.refuse("is empty", "fill", "--box", "0", "0", "0", "1", "1", "0", *cells, "--spacing",
                    "1")
        self.refuse("--sharp-angle", "fill", good, *cells, "--spacing", "1", "--sharp-angle", "0")
        for option in (("--fit-boundary",), ("--depth", "1"), ("--allow-self-intersections",)):
            self.refuse(option[0] + ": is for --cells lattice", "fill", good, *cells, "--spacing",
                        "1", *option)
        self.refuse("--keep-triangles: is for --cells tetrahedra", "fill", good, "--spacing", "1",
                    "--keep-triangles")
        fill = lambda name, content: ("fill", self.path(name, content), *cells, "--spacing", "0.3")
        self.refuse("open.obj", *fill("open.obj", obj(vertices, triangles[1:])))
        self.refuse("", *fill("empty.obj", ""))
        crossing = [(x + 1, y, z) for x, y, z in vertices]
        both = obj(vertices + crossing, triangles +
                   [tuple(v + len(vertices) for v in t) for t in triangles])
        self.refuse("intersects itself", *fill("cross.obj", both))

    def test_ctrl_c_ends_gmsh_and_leaves_nothing(self):
        out = self.path("interrupted.octet.json")
        process = subprocess.Popen([OCTETVDB, "fill", "--box", "0", "0", "0", "1", "1", "1",
                                    "--cells", "tetrahedra", "--spacing", "0.012", "-o", out],
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        children = f"/proc/{process.pid}/task/{process.pid}/children"
        deadline = time.monotonic() + 120

        def child_of(path):
            with open(path) as file:
                return file.read().strip()

        while not child_of(children) and time.monotonic() < deadline:
            time.sleep(0.05)
        child = child_of(children)
        self.assertTrue(child, "Gmsh did not start")
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130, errors)
        self.assertEqual(errors, "octetvdb: cancelled\n")
        self.assertFalse(os.path.exists(out))
        self.assertFalse(os.path.exists(f"/proc/{child}"))


class Add(CommandTest):
    def setUp(self):
        super().setUp()
        self.box = self.path("box.octet.json")
        self.succeed("fill", "--box", "-1", "-1", "-1", "1", "1", "1", "--spacing", "0.4", "-o",
                     self.box)

    def test_sums_are_closed_and_walls_are_tight(self):
        out = self.path("flow.octet.json")
        ring = ("--vortex-ring", "0", "0", "0", "0", "0", "1", "0.5", "2", "0.1")
        summary = self.succeed("add", self.box, *ring, "--uniform", "1", "0", "0", "--curl-noise",
                               "0.3", "1.5", "0.8", "3", "-o", out)
        self.assertEqual(sorted(summary["added"]), ["curl noise", "uniform flow", "vortex ring"])
        self.assertLess(summary["max_derivative"], 1e-14)
        summary = self.succeed("add", out, "--uniform", "-1", "0", "0", "--walls", "-o", out + "2.octet")
        self.assertLess(summary["max_derivative"], 1e-14)
        form = self.succeed("info", out + "2.octet")["forms"][0]
        self.assertEqual(form["boundary"], "walls")

    def test_list_and_options_say_the_same(self):
        listed = self.path("list.json", json.dumps({"primitives": [
            {"type": "source", "point": [0.1, 0, 0], "strength": 2, "core": 0.2},
            {"type": "rotation", "angular_velocity": [0, 0, 1]}]}))
        a, b = self.path("a.octet.json"), self.path("b.octet.json")
        self.succeed("add", self.box, "--degree", "1", "--primitives", listed, "-o", a)
        self.succeed("add", self.box, "--degree", "1", "--source", "0.1", "0", "0", "2", "0.2",
                     "--rotation", "0", "0", "0", "0", "0", "1", "-o", b)
        with open(a) as x, open(b) as y:
            self.assertEqual(json.load(x)["forms"], json.load(y)["forms"])

    def test_refuses_bad_input(self):
        self.refuse("needs a primitive", "add", self.box)
        self.refuse("not finite", "add", self.box, "--uniform", "0", "nan", "0")
        self.refuse("--uniform", "add", self.box, "--uniform", "0", "1")
        self.refuse("needs a core", "add", self.box, "--degree", "1", "--vortex-ring", "0", "0", "0",
                    "0", "0", "1", "1", "1", "0")
        self.refuse("--walls", "add", self.box, "--walls", "--source", "0", "0", "0", "1", "0")
        for content, reason in (
                ("[]", "no array"), ("{", "not JSON"), ('{"primitives": [3]}', "not an object"),
                ('{"primitives": [{"type": "uniform"}]}', "velocity"),
                ('{"primitives": [{"type": "wind", "velocity": [1, 0, 0]}]}', "wind"),
                ('{"primitives": [{"type": "uniform", "velocity": [1, 0]}]}', "three numbers"),
                ('{"primitives": [{"type": "uniform", "velocity": [1, 0, 0], "x": 1}]}', "x")):
            self.refuse(reason, "add", self.box, "--primitives", self.path("bad.json", content))


if __name__ == "__main__":
    unittest.main()
