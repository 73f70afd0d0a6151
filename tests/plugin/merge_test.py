#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`octetvdb bake --shard` and `merge`: what they make together, and what merge refuses.
Argument: the octetvdb command."""
import json
import os
import unittest

import pyopenvdb as vdb

import command

OCTETVDB = command.from_arguments()
BOX = os.path.join(command.SAMPLES, "box", "box.octet.json")
LATTICE = os.path.join(command.SAMPLES, "lattice", "lattice.octet.json")
ANIMATED = os.path.join(command.SAMPLES, "animated", "animated.octet.json")


def content(path):
    with open(path, "rb") as file:
        return file.read()


def changed(options, name, *value):
    """Options with another value of one of them, or with one more."""
    options = list(options)
    if name in options:
        options[options.index(name) + 1:options.index(name) + 2] = value
        return options
    return options + [name, *value]


class Merge(unittest.TestCase):
    def setUp(self):
        temporary = command.temporary_folder()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def succeed(self, *arguments):
        result = OCTETVDB.run(*arguments)
        self.assertEqual((result.returncode, result.stderr), (0, ""), arguments)
        return result.stdout

    def refuse(self, reason, *parts, output="never.vdb"):
        result = OCTETVDB.run("merge", *parts, "-o", self.path(output))
        self.assertIsNone(command.complaint(result))
        self.assertIn(reason, result.stderr)
        self.assertFalse(os.path.exists(self.path("never.vdb")))

    def shards(self, asset, count, *options, name="part"):
        paths = []
        for number in range(1, count + 1):
            paths.append(self.path(f"{name}{number}of{count}.vdb"))
            self.succeed("bake", asset, "-o", paths[-1], "--shard", f"{number}/{count}", *options)
        return paths

    def test_shards_make_the_whole(self):
        for asset, *options in (
                (BOX, "--form", "velocity", "--grid", "staggered", "--levels", 2, "--resolution", 60),
                (LATTICE, "--resolution", 50, "--levels", 1, "--half"),  # forms of every degree
        ):
            self.succeed("bake", asset, "-o", self.path("whole.vdb"), *options)
            for count, threads in ((2, 1), (3, 2)):
                parts = self.shards(asset, count, "--threads", threads, *options)
                sizes = [os.path.getsize(part) for part in parts]
                self.assertLess(max(sizes), 0.8 * os.path.getsize(self.path("whole.vdb")))
                self.succeed("merge", *parts, "-o", self.path("merged.vdb"), "--threads", threads)
                self.assertEqual(content(self.path("merged.vdb")), content(self.path("whole.vdb")))

    def test_sequences_frame_by_frame(self):
        options = ("--voxel-size", 0.2, "--levels", 0, "--frames", "1-2")
        self.succeed("bake", ANIMATED, "-o", self.path("whole.vdb"), *options)
        parts = self.shards(ANIMATED, 2, *options)
        frames = [[part.replace(".vdb", f".000{frame}.vdb") for part in parts] for frame in (1, 2)]
        for frame in (1, 2):
            merged = self.path(f"merged.000{frame}.vdb")
            report = json.loads(self.succeed("merge", *frames[frame - 1], "-o", merged, "--json"))
            self.assertEqual((report["path"], report["frame"]), (merged, frame))
            self.assertEqual(content(merged), content(self.path(f"whole.000{frame}.vdb")))
        self.refuse("is of another bake than", frames[0][0], frames[1][1])

    def test_it_tells_of_parts(self):
        part = self.shards(BOX, 2, "--form", "velocity", "--levels", 1, "--resolution", 40)[0]
        text = self.succeed("verify", part)
        self.assertIn("of this part, where it knows", text)
        file = json.loads(self.succeed("info", part, "--json"))
        (grid,) = file["grids"]
        self.assertEqual(grid["metadata"]["octet_part"], "shard 1 of 2")
        self.assertEqual(grid["metadata"]["octet_certificate"], "partial")
        self.assertEqual(grid["metadata"]["octet_part_of"], file["metadata"]["octet_content"])
        text = self.succeed("bake", BOX, "-o", self.path("r.vdb"), "--form", "velocity",
                            "--levels", 1, "--resolution", 40, "--region", 0.1, 0.1, 0.1, 0.5, 0.5, 0.5)
        self.assertIn("\nregion\n", text)

    def test_wrong_inputs_are_refused(self):
        options = ("--form", "velocity", "--resolution", 40, "--levels", 1)
        one, two, three = self.shards(BOX, 3, *options)
        self.refuse("these are missing: 2", one, three)
        self.refuse("these are missing: 2, 3", one)
        self.refuse("is shard 2 of 3, as is", one, two, two, three)
        self.refuse("is the input itself", one, two, three, output=os.path.basename(two))
        self.refuse("cannot be read", one, two, self.path("absent.vdb"))
        halves = self.shards(BOX, 2, *options)
        self.refuse("is shard 2 of 2, but", one, two, halves[1])
        for other in (("--resolution", 41), ("--half",), ("--grid", "staggered"), ("--levels", 0),
                      ("--target", "arnold"), ("--form", "potential")):
            foreign = self.path("foreign.vdb")
            self.succeed("bake", BOX, "-o", foreign, "--shard", "3/3", *changed(options, *other))
            self.refuse("is of another bake than", one, two, foreign)
        moved = self.path("moved.octet.json")
        with open(BOX) as file:
            asset = json.load(file)
        asset["vertices"][0][0] += 1e-9
        with open(moved, "w") as file:
            json.dump(asset, file)
        self.succeed("bake", moved, "-o", foreign, "--shard", "3/3", *options)
        self.refuse("is of another bake than", one, two, foreign)
        whole, region = self.path("whole.vdb"), self.path("region.vdb")
        self.succeed("bake", BOX, "-o", whole, *options)
        self.refuse("is no part of a bake", whole)
        self.refuse("is no part of a bake", one, two, whole)
        self.succeed("bake", BOX, "-o", region, "--region", 0.1, 0.1, 0.1, 0.4, 0.4, 0.4, *options)
        self.refuse("only shards can be merged", region)
        cut = self.path("cut.vdb")
        with open(cut, "wb") as file:
            file.write(content(three)[:-2000])
        self.refuse("not a readable .vdb", one, two, cut)
        self.refuse("not a readable .vdb", one, two, BOX)

    def test_what_others_made_of_a_part_is_refused(self):
        parts = self.shards(BOX, 2, "--form", "velocity", "--levels", 1, "--resolution", 40)
        grids, _ = vdb.readAll(parts[1])
        changed = self.path("changed.vdb")

        def write(change):
            grid = grids[0].deepCopy()
            change(grid)
            vdb.write(changed, grids=[grid])

        write(lambda grid: grid.fill((8000, 0, 0), (8007, 7, 7), (0.0, 0.0, 1.0), True))
        self.refuse("has tiles", parts[0], changed)
        write(lambda grid: grid.getAccessor().setValueOn((-8000,) * 3, (0.0, 0.0, 1.0)))
        self.refuse("outside of its part", parts[0], changed)

        def rename(grid):
            grid.name = "other"
        write(rename)
        self.refuse("is of another name", parts[0], changed)

        def shift(grid):
            grid["octet_part_window"] = "0 0 0 1 1 1"
        write(shift)
        self.refuse("were not cut alike", parts[0], changed)

        def spoil(grid):
            grid["octet_part_window"] = "0 0 0"
        write(spoil)
        self.refuse("makes no sense", parts[0], changed)


if __name__ == "__main__":
    unittest.main()
