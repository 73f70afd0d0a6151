#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the command behaves: help, options, exit codes, --json, progress, Ctrl-C, full disks, and files
that are complete or not there. Arguments: the octetvdb command."""
import contextlib
import hashlib
import json
import math
import os
import pty
import re
import resource
import select
import signal
import subprocess
import sys
import time
import unittest

import command

sys.path.insert(0, command.SAMPLES)
import octet_asset

OCTETVDB = command.from_arguments()
BOX = os.path.join(command.SAMPLES, "box", "box.octet.json")
GOOD = os.path.join(command.DATA, "wellformed", "good.octet.json")
# Work for many seconds, in whose midst a signal arrives: five million cells, which take 3 GB.
LONG = (GOOD, "--form", "mass", "--resolution", "200", "--levels", "7")


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


class Case(unittest.TestCase):
    def setUp(self):
        temporary = command.temporary_folder()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def files(self):
        return sorted(os.listdir(self.folder))

    def succeed(self, *arguments, **options):
        result = OCTETVDB.run(*arguments, **options)
        self.assertEqual((result.returncode, result.stderr), (0, ""), arguments)
        return result.stdout

    def fail_with(self, code, reason, *arguments, **options):
        """The command ends with a code and one line that holds the reason, and writes nothing."""
        before = self.files()
        result = OCTETVDB.run(*arguments, **options)
        self.assertEqual(result.returncode, code, (arguments, result.stderr))
        self.assertRegex(result.stderr, r"\Aoctetvdb: [^\n]*\n\Z")
        self.assertIn(reason, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertEqual(self.files(), before)


class Help(Case):
    def test_help_and_version(self):
        text = self.succeed("--help")
        for name in ("bake", "info", "refine", "--threads", "--version"):
            self.assertIn(name, text)
        bake = self.succeed("bake", "--help")
        for option in ("--form", "--voxel-size", "--resolution", "--levels", "--boundary", "--grid",
                       "--target", "--half", "--frames", "--threads", "--json", "--d", "-o"):
            self.assertIn(option, bake)
        for name in ("info", "refine"):
            self.assertIn("Usage: octetvdb " + name, self.succeed(name, "--help"))
        self.assertRegex(self.succeed("--version"), r"\A\d+\.\d+\.\d+\n\Z")


class BadUsage(Case):
    def test_commands_and_options(self):
        out = self.path("out.vdb")
        bake = ("bake", BOX, "-o", out)
        small = (*bake, "--resolution", "8")
        for reason, *arguments in (
                ("see octetvdb --help",),
                ("there is no command \"backe\"", "backe"),
                ("CONTROL is required", "bake", "-o", out),
                ("--output is required", "bake", BOX, "--resolution", "8"),
                ("--resolutoin", *bake, "--resolutoin", "8"),
                ("give it or a resolution", *bake),
                ("excludes", *small, "--voxel-size", "0.1"),
                ("not a positive number", *bake, "--resolution", "0"),
                ("not a positive number", *bake, "--resolution", "-4"),
                ("\"8x\"", *bake, "--resolution", "8x"),
                ("not a positive number", *bake, "--voxel-size", "nan"),
                ("not a positive number", *bake, "--voxel-size", "inf"),
                ("not a positive number", *bake, "--voxel-size", ""),
                ("not I/N", *small, "--shard", "2"),
                ("not I/N", *small, "--shard", "1/2/3"),
                ("the first of N is 1/N", *small, "--shard", "0/3"),
                ("the first of N is 1/N", *small, "--shard", "4/3"),
                ("excludes", *small, "--shard", "1/3", "--region", "0", "0", "0", "1", "1", "1"),
                ("6 required", *small, "--region", "0", "0", "0", "1", "1"),
                ("region: is empty", *small, "--region", "0", "0", "0", "1", "1", "-1"),
                ("outside the domain", *small, "--region", "90", "90", "90", "91", "91", "91"),
                ("name it out.vdb", "bake", BOX, "-o", self.path("out.abc"), "--resolution", "8"),
                ("name it out.vdb", "bake", BOX, "-o", self.path("out.nvdb"), "--resolution", "8"),
                ("does not end in .vdb", "bake", BOX, "-o", self.path("out"), "--resolution", "8"),
                ("name it out.vdb", "merge", out, "-o", self.path("out.vdbx")),
                ("PART is required", "merge", "-o", out),
                ("neither auto nor a number", *small, "--levels", "many"),
                ("neither auto nor a number", *small, "--levels", "-1"),
                ("neither auto nor a number", *small, "--levels", "13"),
                ("none of auto, walls, open", *small, "--boundary", "closed"),
                ("none of collocated, staggered", *small, "--grid", "mac"),
                ("none of auto, conservative, samples", *small, "--method", "exact"),
                ("none of openvdb, blender, houdini, arnold, renderman", *small, "--target", "maya"),
                ("there is no form \"vorticity\"; the asset has", *small, "--form", "vorticity"),
                ("not animated", *small, "--frames", "1-3"),
                ("not a list of frames", *small, "--frames", "one"),
                ("not a list of frames", *small, "--frames", "1-"),
                ("did you mean \"--resolution\"?", *bake, "--resolutoin", "8"),
                ("did you mean \"bake\"?", "backe"),
                ("did you mean \"velocity\"?", *small, "--form", "velocty"),
                ("did you mean \"staggered\"?", *small, "--grid", "stagered"),
                ("did you mean \"houdini\"?", *small, "--target", "hudini"),
                ("--zeta", *small, "--zeta", "five"),
                ("zeta", *small, "--zeta", "nan"),
                ("--threads", *small, "--threads", "0"),
                ("--threads", "--threads", "two", *small),
                ("is empty", "bake", BOX, "-o", "", "--resolution", "8"),
                ("is the input itself", "bake", BOX, "-o", BOX, "--resolution", "8"),
                ("levels", "refine", BOX, "-o", out),
                ("levels", "refine", BOX, "-o", out, "--levels", "13"),
                ("more than 100,000,000", "refine", BOX, "-o", out, "--levels", "12"),
                ("not animated", "refine", BOX, "-o", out, "--levels", "1", "--frame", "1"),
                ("FILE is required", "info"),
                ("cannot be read", "info", self.path("missing.vdb")),
        ):
            with self.subTest(arguments=arguments):
                self.fail_with(2, reason, *arguments)

    def test_more_memory_than_there_is_has_a_code_of_its_own(self):
        bake = ("bake", BOX, "-o", self.path("out.vdb"))
        for reason, *options in (
                ("million cells", "--voxel-size", "1e-9"),
                ("voxel size: about ", "--voxel-size", "1e-12", "--levels", "0"),
                ("largest resolution that fits is ", "--resolution", "20000", "--levels", "0")):
            with self.subTest(options=options):
                self.fail_with(33, reason, *bake, *options)

    def test_frames_of_an_animated_asset(self):
        bake = ("bake", GOOD, "-o", self.path("out.vdb"), "--resolution", "6", "--frames")
        self.fail_with(2, "has frames 1-4", *bake, "0-2")
        self.fail_with(2, "has frames 1-4", *bake, "3-5")
        self.fail_with(2, "the first is after the last", *bake, "3-2")
        self.fail_with(2, "has two places", "bake", GOOD, "-o", self.path("a.##.##.vdb"),
                       "--resolution", "6")
        self.fail_with(2, "has frames 1-4", "refine", GOOD, "-o", self.path("out.json"), "--levels",
                       "1", "--frame", "9")


class Extremes(Case):
    """Assets at the edges of what numbers can hold."""

    def asset(self, scale, flux):
        path = self.path("extreme.octet.json")
        with open(path, "w") as file:
            json.dump({"octet": 1, "vertices": [[0, 0, 0], [scale, 0, 0], [0, scale, 0],
                                                [0, 0, scale]], "tetrahedra": [[0, 1, 2, 3]],
                       "forms": [{"name": "f", "degree": 2, "simplices": [[0, 1, 2]],
                                  "values": [flux]}]}, file)
        return path

    def test_large_and_small(self):
        out = self.path("a.vdb")
        for scale, flux in ((1e29, 1e30), (1e-3, 1e-30), (1, 1e30), (1e6, 0)):
            report = json.loads(self.succeed("bake", self.asset(scale, flux), "-o", out, "--json",
                                             "--resolution", "12"))
            grid, = report["files"][0]["grids"]
            self.assertGreater(grid["active_voxels"], 100)
            self.assertTrue(0 <= grid["max"] < 3e38, grid)

    def test_what_floats_cannot_hold(self):
        out = self.path("a.vdb")
        asset = self.asset(1e-5, 1e30)
        self.fail_with(2, "32-bit floats", "bake", asset, "-o", out, "--resolution", "12")
        asset = self.asset(1, 1e5)
        self.fail_with(2, "16-bit floats", "bake", asset, "-o", out, "--resolution", "12", "--half")
        self.succeed("bake", asset, "-o", out, "--resolution", "12")

    def test_voxels_too_small_for_openvdb(self):
        self.fail_with(2, "voxel size", "bake", self.asset(1e-12, 1), "-o", self.path("a.vdb"),
                       "--resolution", "12")

    def test_a_far_vertex_of_no_cell_changes_nothing(self):
        path = self.asset(1, 1)
        with open(path) as file:
            asset = json.load(file)
        asset["vertices"].append([1e9, 0, 0])
        with_stray = self.path("stray.octet.json")
        with open(with_stray, "w") as file:
            json.dump(asset, file)
        reports = [json.loads(self.succeed("bake", p, "-o", self.path("a.vdb"), "--json",
                                           "--resolution", "12")) for p in (path, with_stray)]
        self.assertEqual(*[r["files"][0]["grids"] for r in reports])


class BadOutput(Case):
    def outputs(self, name):
        """The commands that write a file, writing there."""
        return [("bake", BOX, "-o", self.path(name), "--resolution", "8"),
                ("refine", BOX, "-o", self.path(name), "--levels", "1")]

    def test_folders(self):
        for arguments in self.outputs("missing/out.vdb"):
            self.fail_with(1, "No such file or directory", *arguments)
        os.mkdir(self.path("folder"))
        for arguments in self.outputs("folder"):
            self.fail_with(1, "is a folder", *arguments)
        for arguments in self.outputs("/dev/null"):
            self.fail_with(1, "is not a regular file", *arguments)
        for arguments in self.outputs("/proc/out.vdb"):
            self.fail_with(1, "cannot be written", *arguments)

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_folder_that_may_not_be_written(self):
        os.mkdir(self.path("locked"), 0o500)
        for arguments in self.outputs("locked/out.vdb"):
            self.fail_with(1, "Permission denied", *arguments)

    def test_file_size_limit(self):
        """Each write fails at some byte, as on a full disk."""
        def limited(size):
            return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

        for name in ("out.vdb", "out.json", "out.octet"):
            for arguments in self.outputs(name)[0 if name == "out.vdb" else 1:][:1]:
                for size in (0, 100, 4096, 20000):
                    self.fail_with(1, "cannot be written", *arguments, preexec_fn=limited(size))

    def test_full_disk(self):
        """A file system of 64 KiB, where this user may mount one."""
        script = ('mount -t tmpfs -o size=64k tmpfs "$1" || exit 77; shift; "$@"; code=$?; '
                  'ls -A "$DISK" >&2; exit $code')
        os.mkdir(self.path("disk"))
        for name, arguments in (("bake", ("bake", BOX, "--resolution", "40")),
                                ("refine", ("refine", BOX, "--levels", "2"))):
            result = subprocess.run(
                ["unshare", "-rm", "sh", "-c", script, "sh", self.path("disk"), OCTETVDB.path,
                 "--progress", "none", *arguments, "-o", self.path("disk/out.vdb")], capture_output=True, text=True,
                env={**os.environ, "DISK": self.path("disk")})
            if result.returncode == 77 or "unshare" in result.stderr:
                self.skipTest("may not mount a file system: " + result.stderr.strip())
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertRegex(result.stderr, r"\Aoctetvdb: .*No space left on device\n\Z", name)

    def test_summary_that_cannot_be_written(self):
        with open("/dev/full", "w") as full:
            for arguments in (("info", BOX), ("info", BOX, "--json"),
                              ("bake", BOX, "-o", self.path("a.vdb"), "--resolution", "8", "--json")):
                result = OCTETVDB.run(*arguments, capture_output=False, stdout=full,
                                      stderr=subprocess.PIPE)
                self.assertEqual(result.returncode, 1)
                self.assertIn("standard output", result.stderr)


class Summaries(Case):
    def test_bake_json_agrees_with_info_of_what_was_written(self):
        out = self.path("out.vdb")
        report = json.loads(self.succeed("bake", BOX, "-o", out, "--resolution", "20", "--json"))
        self.assertEqual([f["path"] for f in report["files"]], [out])
        self.assertGreater(report["cells"], 0)
        self.assertAlmostEqual(report["voxel_size"] * 20, 3, places=9)
        info = json.loads(self.succeed("info", out, "--json"))
        self.assertEqual(info["kind"], "OpenVDB file")
        self.assertEqual(info["metadata"]["octet_asset"], "box")
        written = {g["name"]: g for g in report["files"][0]["grids"]}
        read = {g["name"]: g for g in info["grids"]}
        self.assertEqual(set(written), {"velocity", "potential"})
        self.assertEqual(set(written), set(read))
        for name, grid in written.items():
            keys = set(grid) & set(read[name])
            self.assertTrue({"type", "class", "active_voxels", "min", "max", "voxel_size"} <= keys)
            for key in keys:
                self.assertEqual(read[name][key], grid[key], (name, key))

    def test_info_of_an_asset(self):
        info = json.loads(self.succeed("info", GOOD, "--json"))
        self.assertEqual([info[k] for k in ("vertices", "edges", "facets", "tetrahedra", "octahedra",
                                            "boundary_facets", "creases", "corners")],
                         [7, 15, 11, 1, 1, 10, 2, 3])  # ends of a crease are corners
        self.assertAlmostEqual(info["volume"], 4 / 3 + 1.25 / 6)
        self.assertEqual([(f["name"], f["degree"], f["nonzero"]) for f in info["forms"]],
                         [("pressure", 0, 2), ("potential", 1, 2), ("velocity", 2, 2), ("mass", 3, 2)])
        self.assertEqual(info["forms"][1]["frames"], [1, 3])
        self.assertEqual(sum(info["vertex_types"].values()), 7)
        # As text: one line a key, numbers unbroken.
        text = self.succeed("info", GOOD)
        self.assertIn("box: [[-1.0,-1.0,-1.0],[1.0,1.0,1.0]]\n", text)
        self.assertIn("  name: velocity\n", text)
        # The same document as CBOR says the same, and a mesh is described like an asset.
        cbor = json.loads(self.succeed("info", GOOD[:-len(".json")], "--json"))
        self.assertEqual(cbor, info)

    def test_closed_forms_are_seen_to_be_closed(self):
        forms = {f["name"]: f for f in json.loads(self.succeed("info", BOX, "--json"))["forms"]}
        self.assertLess(forms["velocity"]["max_derivative"], 1e-15)
        self.assertGreater(forms["potential"]["max_derivative"], 1e-3)


class Numbering(Case):
    def test_frames_become_numbered_files(self):
        self.succeed("bake", GOOD, "-o", self.path("a.vdb"), "--resolution", "6")
        self.assertEqual(self.files(), [f"a.000{n}.vdb" for n in (1, 2, 3, 4)])

    def test_frames_chosen(self):
        self.succeed("bake", GOOD, "-o", self.path("a.vdb"), "--resolution", "6", "--frames", "2-3")
        self.assertEqual(self.files(), ["a.0002.vdb", "a.0003.vdb"])
        self.succeed("bake", GOOD, "-o", self.path("b.vdb"), "--resolution", "6", "--frames", "4")
        self.assertEqual(self.files(), ["a.0002.vdb", "a.0003.vdb", "b.0004.vdb"])

    def test_constant_forms_make_one_file(self):
        self.succeed("bake", GOOD, "-o", self.path("a.vdb"), "--resolution", "6", "--form", "mass")
        self.assertEqual(self.files(), ["a.vdb"])


class SameBytes(Case):
    def test_one_thread_and_two_and_again(self):
        for options in ([], ["--grid", "staggered"], ["--reconstruction", "whitney"], ["--d"],
                        ["--half", "--target", "blender"], ["--boundary", "open"]):
            with self.subTest(options=options):
                digests = set()
                for threads in ("1", "2", "2"):
                    self.succeed("bake", BOX, "-o", self.path("a.vdb"), "--resolution", "32",
                                 "--threads", threads, *options)
                    digests.add(digest(self.path("a.vdb")))
                self.assertEqual(len(digests), 1)

    def test_refine(self):
        for name in ("a.json", "a.octet"):
            digests = set()
            for threads in ("1", "2"):
                self.succeed("refine", BOX, "-o", self.path(name), "--levels", "2", "--threads",
                             threads)
                digests.add(digest(self.path(name)))
            self.assertEqual(len(digests), 1)

    def test_different_bakes_differ_in_their_tag_too(self):
        tags = set()
        for resolution in ("8", "9", "10"):
            self.succeed("bake", BOX, "-o", self.path("a.vdb"), "--resolution", resolution)
            with open(self.path("a.vdb"), "rb") as file:
                tags.add(file.read()[21:57])
        self.assertEqual(len(tags), 3)
        for tag in tags:
            self.assertRegex(tag.decode(), r"\A[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\Z")


class DryRun(Case):
    """A dry run decides as the bake does, and writes nothing."""

    BAKES = (
        (BOX, "--resolution", "24"),
        (BOX, "--form", "potential", "--d", "--grid", "staggered", "--resolution", "24"),
        (BOX, "--form", "velocity", "--resolution", "48", "--levels", "1"),  # too fine for means
        (BOX, "--form", "velocity", "--resolution", "20", "--method", "samples", "--half"),
        (os.path.join(command.SAMPLES, "animated", "animated.octet.json"), "--voxel-size", "0.3",
         "--frames", "1-2", "--target", "houdini"))

    def test_it_decides_as_the_bake_does(self):
        for number, bake in enumerate(self.BAKES):
            common = ("bake", *bake, "-o", self.path(f"{number}.vdb"), "--json")
            before = self.files()
            plan = json.loads(self.succeed(*common, "--dry-run"))
            self.assertEqual(self.files(), before)
            report = json.loads(self.succeed(*common))
            for key in ("levels", "voxel_size", "note"):
                self.assertEqual(plan[key], report[key])
            self.assertAlmostEqual(plan["mean_edge"] / report["mean_edge"], 1, delta=0.05)
            self.assertEqual(plan["cells"], report["cells"])
            self.assertLess(report["cells"], plan["bytes"])
            self.assertEqual([f["path"] for f in plan["files"]],
                             [f["path"] for f in report["files"]])
            self.assertEqual([f.get("frame") for f in plan["files"]],
                             [f.get("frame") for f in report["files"]])
            for planned, baked in zip(plan["files"], report["files"]):
                self.check_grids(planned["grids"], baked["grids"])

    def check_grids(self, planned, baked):
        self.assertEqual([g["name"] for g in planned], [g["name"] for g in baked])
        for plan, grid in zip(planned, baked):
            self.assertEqual(plan.get("method"), grid.get("method"))
            # Numbers of a plan are foreseen; what they are said of is the same.
            said = "; ".join(r["note"] for r in plan.get("reasons", []))
            self.assertEqual(re.sub(r"[0-9.]+", "#", said),
                             re.sub(r"[0-9.]+", "#", grid.get("note", "")))

    def test_it_tells_people(self):
        text = self.succeed("bake", BOX, "--form", "velocity", "--resolution", "48", "--levels", "1",
                            "-o", self.path("a.vdb"), "--dry-run")
        self.assertIn("1 levels, about ", text)
        self.assertIn("GB of memory", text)
        self.assertRegex(text, r"collocated from samples; voxels are [0-9.]+ fine edges")
        self.assertEqual(self.files(), [])

    def test_it_tells_of_more_than_there_is(self):
        plan = json.loads(self.succeed("bake", BOX, "--form", "velocity", "--resolution", "24",
                                       "--levels", "12", "-o", self.path("a.vdb"), "--dry-run",
                                       "--json"))
        self.assertGreater(plan["bytes"], plan["memory"])


class BoundaryMethods(Case):
    """What the thesis' methods at the boundary do not keep is said, and what they keep is kept."""

    def lattice(self, gap):
        """A block of the lattice with a turning flow; `gap`: without the octahedron inside."""
        cage = octet_asset.lattice(lambda p: sum(map(abs, p)) <= 4, 4, creases=[])
        if gap:
            beside = {(x, y, z) for x, y, z in ((0, 0, 0), (2, 0, 0), (1, 1, 0), (1, -1, 0),
                                                (1, 0, 1), (1, 0, -1))}
            octahedra = [o for o in cage.octahedra if {cage.vertices[v] for v in o} != beside]
            self.assertEqual(len(octahedra), len(cage.octahedra) - 1)
            cage = octet_asset.Cage(cage.vertices, cage.tetrahedra, octahedra, creases=[])
        potential = {e: cage.circulation(lambda p: (p[1] * p[2], 0.3 * p[0], p[1] ** 2), e)
                     for e in cage.edges}
        path = self.path("lattice.octet.json")
        octet_asset.write(path, "lattice", cage, [octet_asset.form("a", 1, "m^2/s", potential)])
        return path

    def baked(self, asset, boundary, *options):
        out = self.path("a.vdb")
        report = json.loads(self.succeed(
            "bake", asset, "-o", out, "--d", "--grid", "staggered", "--boundary", boundary,
            "--resolution", "12", "--levels", "1", "--json", *options))
        (grid,) = report["files"][0]["grids"]
        (stored,) = json.loads(self.succeed("info", out, "--json"))["grids"]
        self.assertEqual(stored["metadata"].get("octet_note", ""), grid.get("note", ""))
        return grid

    def test_expansion_bakes_circulations(self):
        asset = self.lattice(gap=False)
        grid = self.baked(asset, "expansion")
        self.assertEqual(grid["method"], "circulations")
        self.assertNotIn("note", grid)
        self.assertLess(grid["certificate"]["divergence_max"], 1e-6)
        refined = self.succeed("refine", asset, "-o", self.path("a.json"), "--levels", "1",
                               "--boundary", "expansion")
        self.assertEqual(refined, "")

    def test_a_gap_that_the_virtual_layer_fills_is_told(self):
        asset = self.lattice(gap=True)
        grid = self.baked(asset, "expansion")
        self.assertEqual(grid["method"], "samples")
        self.assertIn("fills a gap", grid["note"])
        self.assertIn("sampled", grid["note"])
        out = self.path("a.json")
        report = json.loads(self.succeed("refine", asset, "-o", out, "--levels", "1", "--boundary",
                                         "expansion", "--json"))
        with open(out) as file:
            self.assertEqual(json.load(file)["note"], report["note"])
        self.assertIn("fills a gap", report["note"])

    def test_methods_without_potentials_say_so(self):
        asset = self.lattice(gap=False)
        for boundary in ("simple", "projection"):
            grid = self.baked(asset, boundary)
            self.assertEqual(grid["method"], "samples")
            self.assertIn(boundary, grid["note"])
            self.assertIn("sampled", grid["note"])

    def test_a_dry_run_says_what_methods_lose(self):
        asset = self.lattice(gap=True)
        common = ("bake", asset, "-o", self.path("a.vdb"), "--d", "--resolution", "12", "--levels",
                  "1", "--boundary", "expansion", "--json")
        (plan,) = json.loads(self.succeed(*common, "--dry-run"))["files"][0]["grids"]
        (grid,) = json.loads(self.succeed(*common))["files"][0]["grids"]
        self.assertEqual([r["reason"] for r in plan["reasons"]],
                         ["method_loses", "no_refined_potential"])
        self.assertEqual("; ".join(r["note"] for r in plan["reasons"]), grid["note"])

    def test_the_virtual_layer_can_be_looked_at(self):
        asset, out = self.lattice(gap=False), self.path("a.json")
        self.succeed("refine", asset, "-o", out, "--levels", "0", "--boundary", "expansion",
                     "--virtual-layer")
        with open(out) as file:
            document = json.load(file)
        self.assertGreater(len(document["tetrahedra"]), 80)
        self.assertEqual(len(document["forms"]["a"]["values"]), len(document["edges"]))
        self.fail_with(2, "--virtual-layer", "refine", asset, "-o", self.path("b.json"), "--levels",
                       "1", "--boundary", "expansion", "--virtual-layer")


class Terminal:
    """The command with its stderr on a pseudo terminal."""

    def __init__(self, *arguments):
        self.master, slave = pty.openpty()
        self.process = OCTETVDB.start(*arguments, progress="auto", stderr=slave)
        os.close(slave)
        self.text = ""

    def read(self, until=None):
        """Reads until the text holds `until`, or to the end."""
        deadline = time.monotonic() + command.TIME_LIMIT
        while until is None or not re.search(until, self.text):
            if not select.select([self.master], [], [], max(0, deadline - time.monotonic()))[0]:
                raise TimeoutError(self.text[-500:])
            with contextlib.suppress(OSError):  # the other end was closed
                piece = os.read(self.master, 4096).decode()
                self.text += piece
                if piece:
                    continue
            break
        return self.text

    def wait(self):
        self.read()
        self.process.stdout.read()
        code = self.process.wait(command.TIME_LIMIT)
        os.close(self.master)
        self.process.stdout.close()
        return code


class Progress(Case):
    def test_on_a_terminal(self):
        terminal = Terminal("bake", BOX, "-o", self.path("a.vdb"), "--levels", "4", "--resolution",
                            "250")
        self.assertEqual(terminal.wait(), 0)
        for stage in ("build level 4", "bake velocity"):
            self.assertRegex(terminal.text, stage + r" +\d+ %  [0-9.e+]+ [a-z]+/s  \d+:\d\d left")
        # One line, overwritten, and wiped at the end.
        self.assertNotIn("\n", terminal.text)
        self.assertTrue(terminal.text.endswith("\r\x1b[K"))


class Interrupted(Case):
    """Ctrl-C, or a farm's SIGTERM, in the midst of work: the shell's exit code for it, no file, no
    temporary file."""

    def interrupt(self, stage, arguments, sent=signal.SIGINT, left=()):
        terminal = Terminal(*arguments)
        terminal.read(until=stage)
        terminal.process.send_signal(sent)
        self.assertEqual(terminal.wait(), 128 + sent, terminal.text[-300:])
        self.assertTrue(terminal.text.endswith("octetvdb: cancelled\r\n"), terminal.text[-300:])
        self.assertEqual(self.files(), sorted(left))

    def test_while_levels_are_built(self):
        bake = ("bake", *LONG, "-o", self.path("a.vdb"))
        self.interrupt("build level [67]", bake)
        self.interrupt("build level [67]", bake, sent=signal.SIGTERM)

    def test_while_grids_are_baked(self):
        self.interrupt("bake velocity +[0-9]", ("bake", BOX, "-o", self.path("a.vdb"), "--resolution",
                                             "400", "--levels", "3"))

    def test_while_a_grid_is_written(self):
        self.interrupt("write a.vdb", ("bake", BOX, "-o", self.path("a.vdb"), "--resolution", "300",
                                       "--levels", "1"))

    def test_while_a_document_is_written(self):
        for name in ("a.json", "a.octet"):
            self.interrupt("write document +[0-9]", ("refine", BOX, "-o", self.path(name), "--levels",
                                                  "4"))

    def test_at_any_moment_of_a_fill(self):
        """A million cells: distances, lattice, mesh, document. None goes on for long."""
        fills = (("fill", "--box", "0", "0", "0", "1", "1", "1", "--spacing", "0.017"),
                 ("fill", self.sphere(), "--spacing", "0.02"))
        for fill in fills:
            stopped = 0
            for delay in (0.3, 0.7, 1.2, 2, 3, 4, 5, 6):
                process = OCTETVDB.start(*fill, "-o", self.path("a.octet"))
                time.sleep(delay)
                if process.poll() is not None:
                    process.communicate()
                    break
                self.assertLess(command.stop(process), command.AT_ONCE, (fill, delay))
                self.assertIn(process.returncode, (0, 128 + signal.SIGTERM))
                stopped += process.returncode != 0
            self.assertGreater(stopped, 1, fill)

    def sphere(self):
        """A surface around (0, 0, 0) of radius 1, of 20 000 triangles."""
        path, n = self.path("sphere.obj"), 100
        self.addCleanup(os.remove, path)
        with open(path, "w") as file:
            file.write("v 0 0 1\nv 0 0 -1\n")
            for i in range(1, n):
                for j in range(n):
                    a, b = math.pi * i / n, 2 * math.pi * j / n
                    file.write(f"v {math.sin(a) * math.cos(b)} {math.sin(a) * math.sin(b)} "
                               f"{math.cos(a)}\n")
            at = lambda i, j: 3 + (i - 1) * n + j % n
            for j in range(n):
                file.write(f"f 1 {at(1, j)} {at(1, j + 1)}\n")
                file.write(f"f 2 {at(n - 1, j + 1)} {at(n - 1, j)}\n")
                for i in range(1, n - 1):
                    file.write(f"f {at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)} {at(i, j + 1)}\n")
        return path

    def test_what_was_there_before_stays(self):
        with open(self.path("a.vdb"), "w") as file:
            file.write("precious")
        self.interrupt("bake velocity +[0-9]", ("bake", BOX, "-o", self.path("a.vdb"), "--resolution",
                                             "400", "--levels", "3"), left=["a.vdb"])
        with open(self.path("a.vdb")) as file:
            self.assertEqual(file.read(), "precious")

    def test_finished_frames_stay(self):
        terminal = Terminal("bake", GOOD, "-o", self.path("a.vdb"), "--resolution", "150", "--levels",
                            "4")
        deadline = time.monotonic() + command.TIME_LIMIT
        while "a.0001.vdb" not in self.files() and time.monotonic() < deadline:
            time.sleep(0.001)
        terminal.process.send_signal(signal.SIGINT)
        self.assertEqual(terminal.wait(), 130)
        finished = self.files()
        self.assertIn("a.0001.vdb", finished)
        self.assertLess(len(finished), 4)
        for name in finished:
            self.succeed("info", self.path(name))  # complete

    def test_without_a_terminal(self):
        process = OCTETVDB.start("bake", *LONG, "-o", self.path("a.vdb"))
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=command.TIME_LIMIT)
        self.assertEqual((process.returncode, out, err), (130, "", "octetvdb: cancelled\n"))
        self.assertEqual(self.files(), [])

    def test_a_second_one_ends_it_at_once(self):
        terminal = Terminal("bake", *LONG, "-o", self.path("a.vdb"))
        terminal.read(until="build level [67]")
        terminal.process.send_signal(signal.SIGTERM)
        with contextlib.suppress(ProcessLookupError):
            terminal.process.send_signal(signal.SIGTERM)
        self.assertIn(terminal.wait(), (-signal.SIGTERM, 128 + signal.SIGTERM))
        self.assertEqual(self.files(), [])


class NeverHalfThere(Case):
    def test_whoever_looks_sees_the_old_file_or_the_new(self):
        out = self.path("a.vdb")
        seen = set()
        self.succeed("bake", BOX, "-o", out, "--resolution", "16")
        old = digest(out)
        process = OCTETVDB.start("bake", BOX, "-o", out, "--resolution", "64", "--levels", "1")
        while process.poll() is None:
            seen.add(digest(out))
        process.communicate()
        self.assertEqual(process.returncode, 0)
        self.assertNotEqual(digest(out), old)
        self.assertLessEqual(seen, {old, digest(out)})
        self.assertIn(old, seen)
        self.assertEqual(self.files(), ["a.vdb"])

    def test_two_at_once_do_not_mix(self):
        out = self.path("a.vdb")
        whole = set()
        for resolution in ("30", "40"):
            self.succeed("bake", BOX, "-o", out, "--resolution", resolution)
            whole.add(digest(out))
        processes = [OCTETVDB.start("bake", BOX, "-o", out, "--resolution", r) for r in ("30", "40")]
        for process in processes:
            process.communicate(timeout=command.TIME_LIMIT)
            self.assertEqual(process.returncode, 0)
        self.assertIn(digest(out), whole)
        self.assertEqual(self.files(), ["a.vdb"])


if __name__ == "__main__":
    unittest.main()
