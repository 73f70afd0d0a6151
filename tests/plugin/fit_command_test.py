#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`octetvdb fit`: guide files in their formats, what is written, bad guides refused with their line.
Arguments: the octetvdb command.
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples"))
import octet_asset as oa

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SIZE = (2.0, 2.0, 2.0)


def circle(height, radius=0.5, count=32):
    turns = [2 * math.pi * (k % count) / count for k in range(count + 1)]
    return [(radius * math.cos(t), radius * math.sin(t), height) for t in turns]


HEIGHTS = (-0.4, 0.0, 0.4)


class Fit(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.cage = oa.box((4, 4, 4), SIZE)
        oa.write(self.path("cage.octet.json"), "cage", self.cage, [])

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def csv(self, name="guides.csv", change=lambda lines: None):
        lines = ["curve,x,y,z,speed"]
        for k, height in enumerate(HEIGHTS):
            lines += [f"ring {k},{x!r},{y!r},{z!r},1.5" for x, y, z in circle(height)]
        change(lines)
        return self.write(name, "\n".join(lines) + "\n")

    def fit(self, *arguments, code=0):
        out = self.path("out.octet.json")
        if os.path.exists(out):
            os.remove(out)
        result = subprocess.run([OCTETVDB, "--progress", "none", "fit", self.path("cage.octet.json"), *arguments, "-o", out,
                                 "--json"], capture_output=True, text=True)
        self.assertEqual(result.returncode, code, result.stderr)
        if code:
            self.assertFalse(os.path.exists(out))
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            return result.stderr
        with open(out) as file:
            return json.loads(result.stdout), json.load(file)

    def form(self, asset, name="velocity"):
        form = next(f for f in asset["forms"] if f["name"] == name)
        return form, {tuple(s): v for s, v in zip(form["simplices"], form["values"])}

    def check_flux(self, asset, given=None):
        """Walls let nothing pass, cells neither gain nor lose."""
        form, flux = self.form(asset)
        self.assertEqual(form["degree"], 2)
        for facet in self.cage.boundary_facets:
            self.assertEqual(flux.get(facet, 0.0), (given or {}).get(facet, 0.0), facet)
        largest = max(map(abs, flux.values()))
        for a, b, c, d in map(sorted, self.cage.tetrahedra):
            total = (flux.get((b, c, d), 0) - flux.get((a, c, d), 0) + flux.get((a, b, d), 0)
                     - flux.get((a, b, c), 0))
            self.assertAlmostEqual(total, 0, delta=1e-13 * largest)

    def test_formats_say_the_same(self):
        obj = ["# Blender"]
        first = 1
        for k, height in enumerate(HEIGHTS):
            points = circle(height)
            obj += [f"o ring_{k}"] + ["v %r %r %r" % p for p in points]
            numbers = range(first, first + len(points))
            if k == 0:
                obj.append("l " + " ".join(map(str, numbers)))
            elif k == 1:
                obj += [f"l {a} {a + 1}" for a in numbers[:-1]]
            else:
                obj.append("l " + " ".join(str(a - first - len(points)) for a in numbers))
            first += len(points)
        curves = [{"name": f"ring {k}", "points": circle(h), "speed": 1.5}
                  for k, h in enumerate(HEIGHTS)]
        files = [self.csv(),
                 self.csv("semicolons.csv", lambda lines: lines.__setitem__(
                     slice(None), [line.replace(",", "; ") for line in lines])),
                 self.write("guides.obj", "\n".join(obj) + "\n"),
                 self.write("guides.json", json.dumps({"curves": curves}))]
        results = []
        for file in files:
            report, asset = self.fit("--guides", file, "--speed", "1.5")
            self.assertEqual(len(report["guides"]), 3)
            for guide in report["guides"]:
                self.assertLess(guide["residual"], 0.05, guide["name"])
            self.check_flux(asset)
            results.append(asset["forms"])
        for other in results[1:]:
            self.assertEqual(other, results[0])
        report, asset = self.fit("--guides", files[0], "--guides", self.write(
            "more.csv", "name,x,y,z,vx,vy,vz,weight\nup,0.1,0.1,0.1,0,0,0.5,2\n"))
        self.assertEqual([g["name"] for g in report["guides"]],
                         ["ring 0", "ring 1", "ring 2", "up"])

    def test_kinds(self):
        guides = self.csv()
        report, asset = self.fit("--guides", guides, "--potential", "stream")
        form, potential = self.form(asset, "stream")
        self.assertEqual(form["degree"], 1)
        _, flux = self.form(asset)
        for a, b, c in self.cage.facets:
            self.assertAlmostEqual(
                potential.get((a, b), 0) + potential.get((b, c), 0) - potential.get((a, c), 0),
                flux.get((a, b, c), 0), delta=1e-13)
        self.assertLess(report["divergence"], 1e-13)
        self.assertEqual(report["boundary"], "walls")

        straight = self.write("straight.json", json.dumps({"curves": [
            {"name": "a", "points": [[-0.8, 0, 0], [0.8, 0, 0]], "speeds": [1, 1]}]}))
        report, asset = self.fit("--guides", straight, "--curl-free", "--walls", "open",
                                 "--potential", "height")
        self.assertEqual(self.form(asset)[0]["degree"], 1)
        self.assertEqual(self.form(asset, "height")[0]["degree"], 0)
        self.assertLess(report["residual"], 1e-3)
        self.assertEqual(report["boundary"], "open")
        report, asset = self.fit("--guides", straight, "--free")
        self.assertLess(report["residual"], 0.05)
        self.assertGreater(report["divergence"], 1e-6)

    def test_given_flux(self):
        ends = {}
        for facet in self.cage.boundary_facets:
            if all(abs(self.cage.vertices[v][0] + 1) < 1e-9 for v in facet):
                ends[facet] = -1
            if all(abs(self.cage.vertices[v][0] - 1) < 1e-9 for v in facet):
                ends[facet] = 1
        self.assertEqual(len(ends), 64)
        given = {f: self.cage.flux(lambda p: (1.0, 0.0, 0.0), f) for f in ends}
        flux = self.write("flux.json", json.dumps({"simplices": list(given),
                                                   "values": list(given.values())}))
        straight = self.write("straight.json", json.dumps({"curves": [
            {"points": [[-0.9, 0.1, 0], [0.9, 0.1, 0]], "speed": 1}]}))
        report, asset = self.fit("--guides", straight, "--flux", flux)
        self.assertLess(report["residual"], 0.05)
        self.check_flux(asset, given)
        self.assertTrue(any("--boundary walls" in r for r in report["remarks"]))
        inside = next(f for f in self.cage.facets if f not in self.cage.boundary_facets)
        for text, *parts in (
                ('{"values": [1], "simplices": [\n%s]}' % json.dumps(inside), "line 2, simplices[0]",
                 "not on the boundary"),
                (json.dumps({"simplices": [[0, 1, 1e6]], "values": [1]}), "out of range"),
                (json.dumps({"simplices": list(given), "values": [1]}), "1 values"),
                (json.dumps({"simplices": list(given),
                             "values": [2 * v if k == 0 else v
                                        for k, v in enumerate(given.values())]}),
                 "divergence-free")):
            message = self.fit("--guides", straight, "--flux", self.write("bad.json", text), code=2)
            for part in parts:
                self.assertIn(part, message)

    def test_conflict_is_said(self):
        guides = self.write("guides.json", json.dumps({"curves": [
            {"name": "there", "points": [[-0.5, 0, 0], [0.5, 0, 0]]},
            {"name": "back", "points": [[0.5, 0, 0], [-0.5, 0, 0]]}]}))
        report, _ = self.fit("--guides", guides)
        self.assertEqual(report["conflicts"][0]["first"], "there")
        self.assertEqual(report["conflicts"][0]["second"], "back")
        self.assertGreater(report["guides"][0]["residual"], 0.5)
        self.assertTrue(report["remarks"])

    def test_bad_guides_are_refused_with_their_line(self):
        def line(number, text):
            return lambda lines: lines.__setitem__(number - 1, text)

        for change, *parts in (
                (line(5, "ring 0,3,0,0,1"), "line 4", "outside"),
                (line(9, "ring 0,nan,0,0,1"), "line 9", "finite"),
                (line(9, "ring 0,0.1,0,inf,1"), "line 9", "finite"),
                (line(9, "ring 0,0.1,0,0,nan"), "line 9", "finite"),
                (line(7, "ring 0,0.1,zero,0,1"), "line 7", "column y", "zero"),
                (line(7, "ring 0,0.1,0"), "line 7", "3 columns"),
                (lambda lines: lines.insert(4, lines[3]), "line 5", "zero length"),
                (lambda lines: lines.__delitem__(slice(2, None)), "line 2", "two points"),
                (line(1, "curve,x,y,zed,speed"), "line 1", "zed"),
                (lambda lines: lines.__delitem__(slice(1, None)), "no guides")):
            message = self.fit("--guides", self.csv(change=change), code=2)
            for part in ("guides.csv", *parts):
                self.assertIn(part, message)
        for name, text, *parts in (
                ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 3\n", "line 3", "\"3\""),
                ("a.obj", "v 0 0 0\nv 0.5 0 x\nl 1 2\n", "line 2", "\"x\""),
                ("a.obj", "v 0 0 0\nv 0.5 0 0\nl 1\n", "line 3", "two vertices"),
                ("a.obj", "v 0 0 0\nv 5 0 0\n\nl 1 2\n", "line 1", "outside"),
                ("a.obj", "v 0 0 0\n", "no polylines"),
                ("a.json", "[1]", "is not a guide file: the document is not an object"),
                ("a.json", '{"curves": [{"points": [[0, 0], [1, 0]]}]}', "line 1",
                 "curves[0].points[0]"),
                ("a.json", '{"curves": [\n{"points": [\n[0,0,0],\n[0,0,0]\n]}]}', "line 4",
                 "curves[0].points[1]", "zero length"),
                ("a.json", '{"curves": [{"points": [\n[0,9,\n0], [1\n,9,0]]}]}', "line 2",
                 "curves[0].points[0]", "outside"),
                ("a.json", '{"curves": [{"points": [[0,0,0],\r\n[0,NaN,0]]}]}', "line 2"),
                ("a.json", '{"curves": [{"points": [[0,0,0],\n[0,1e999,0]]}]}', "line 2",
                 "curves[0].points[1][1]"),
                ("a.json", '{"curves": [{"points": [[0,0,0], [0.5,0,0]],\n"weight": -1\n}]}',
                 "line 1", "weight"),
                ("a.json", '{"curves": [{"points": [[0,0,0], [0.5,0,0]],\n\n"speed": "1"\n}]}',
                 "line 3", "curves[0].speed", "not a number"),
                ("a.json", '{"vectors": [\n\n{"point": [9, 0, 0],\n"value": [1, 0, 0]}]}', "line 3",
                 "vectors[0]", "outside"),
                ("a.json", '{"curves": [{"points": [[0,0,0], [0.5,0,0]],\n"sped": 1\n}]}',
                 "line 2", "curves[0].sped"),
                # Longer than what is read at once.
                ("a.json", '{"curves": [{"points": [' + "\n" * 200000 + '[0,0,0], [0,0,0]]}]}',
                 "line 200001", "zero length"),
                ("a.txt", "", ".obj, .csv and .json")):
            message = self.fit("--guides", self.write(name, text), code=2)
            for part in (name, *parts):
                self.assertIn(part, message)
        self.assertIn("cannot be read", self.fit("--guides", self.path("none.csv"), code=2))
        self.assertIn("smoothness", self.fit("--guides", self.csv(), "--smoothness", "-1", code=2))
        self.assertIn("do not determine",
                      self.fit("--guides", self.csv(), "--smoothness", "0", code=2))


if __name__ == "__main__":
    unittest.main(verbosity=2)
