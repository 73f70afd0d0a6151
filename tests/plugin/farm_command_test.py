#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What farms and scripts need of the command: names of frames, frames that are there already, progress
for each farm, threads and memory that it grants, exit codes, JSON for errors and versions, the man page
and bash's completion. Arguments: the octetvdb command."""
import hashlib
import json
import os
import re
import subprocess
import tempfile
import unittest

import command

OCTETVDB = command.from_arguments()
ANIMATED = os.path.join(command.SAMPLES, "animated", "animated.octet.json")
BOX = os.path.join(command.SAMPLES, "box", "box.octet.json")
SMALL = ("bake", ANIMATED, "--resolution", "8")


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
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def fail_with(self, code, reason, *arguments, **options):
        result = OCTETVDB.run(*arguments, **options)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(reason, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1)
        return result


class Names(Case):
    def test_every_way_to_write_a_frame(self):
        for name, becomes in (("a.####.vdb", "a.0003.vdb"), ("a.@.vdb", "a.3.vdb"),
                              ("a.@@@.vdb", "a.003.vdb"), ("a.%04d.vdb", "a.0003.vdb"),
                              ("a.$F4.vdb", "a.0003.vdb"), ("a.<frame>.vdb", "a.0003.vdb"),
                              ("a.vdb", "a.0003.vdb"), ("a_##.vdb", "a_03.vdb")):
            with self.subTest(name=name), tempfile.TemporaryDirectory() as folder:
                said = self.succeed(*SMALL, "--frames", "3", "-o", os.path.join(folder, name))
                self.assertEqual(os.listdir(folder), [becomes])
                self.assertIn(becomes, said)

    def test_lists_of_frames(self):
        for frames, baked in (("1-3", [1, 2, 3]), ("1-9x4", [1, 5, 9]), ("1,3,7-8", [1, 3, 7, 8])):
            with self.subTest(frames=frames), tempfile.TemporaryDirectory() as folder:
                report = json.loads(self.succeed(*SMALL, "--json", "--frames", frames, "-o",
                                                 os.path.join(folder, "a.#.vdb")))
                self.assertEqual([f["frame"] for f in report["files"]], baked)
                self.assertEqual(sorted(os.listdir(folder)), [f"a.{n}.vdb" for n in baked])

    def test_frames_before_zero(self):
        with open(ANIMATED) as file:
            asset = json.load(file)
        form, = asset["forms"]
        first = form["frames"]["1"]
        form["frames"] = {"-5": first, "5": first}
        moved = self.path("moved.octet.json")
        with open(moved, "w") as file:
            json.dump(asset, file)
        report = json.loads(self.succeed("bake", moved, "--resolution", "8", "--json", "--frames",
                                         "-5-5x5", "-o", self.path("a.####.vdb")))
        self.assertEqual([os.path.basename(f["path"]) for f in report["files"]],
                         ["a.-005.vdb", "a.0000.vdb", "a.0005.vdb"])

    def test_other_commands_put_a_frame_there_or_refuse(self):
        self.succeed("refine", ANIMATED, "--levels", "0", "--frame", "2", "-o", self.path("r.##.json"))
        self.assertEqual(self.files(), ["r.02.json"])
        for arguments in (("refine", BOX, "--levels", "0", "-o", self.path("r.##.json")),
                          ("bake", BOX, "--resolution", "8", "-o", self.path("a.####.vdb")),
                          ("fill", "--box", 0, 0, 0, 1, 1, 1, "--spacing", 1, "-o",
                           self.path("a.@.octet.json"))):
            self.fail_with(2, "has a place for a frame, and there is none", *arguments)
        self.assertEqual(self.files(), ["r.02.json"])

    def test_sequences_as_inputs(self):
        self.succeed(*SMALL, "--frames", "1-4", "-o", self.path("a.####.vdb"))
        sample = ("sample", ANIMATED, self.path("a.####.vdb"), "--levels", 0, "-o",
                  self.path("s.octet"), "--json")
        frames = [f["frame"] for f in json.loads(self.succeed(*sample))["frames"]]
        self.assertEqual(frames, [1, 2, 3, 4])
        frames = [f["frame"] for f in json.loads(self.succeed(*sample, "--frames", "1-4x2"))["frames"]]
        self.assertEqual(frames, [1, 3])
        self.fail_with(2, "no file is named like", "sample", ANIMATED, self.path("b.##.vdb"), "-o",
                       self.path("t.octet"))
        self.fail_with(2, "cannot be read", "sample", ANIMATED, self.path("a.####.vdb"), "--frames",
                       "9", "-o", self.path("t.octet"))


class SkipExisting(Case):
    def bake(self, *options, asset=ANIMATED):
        report = json.loads(self.succeed("bake", asset, "--resolution", "8", "--skip-existing",
                                         "--frames", "1-3", "-o", self.path("a.#.vdb"), "--json",
                                         *options))
        return [f["frame"] for f in report["files"] if not f.get("skipped")]

    def test_only_what_is_missing_or_other_is_baked(self):
        self.assertEqual(self.bake(), [1, 2, 3])
        before = {name: (digest(self.path(name)), os.stat(self.path(name)).st_mtime_ns)
                  for name in self.files()}
        self.assertEqual(self.bake(), [])
        os.remove(self.path("a.2.vdb"))
        os.truncate(self.path("a.3.vdb"), os.path.getsize(self.path("a.3.vdb")) - 1)
        self.assertEqual(self.bake(), [2, 3])
        for name, (content, time) in before.items():
            self.assertEqual(digest(self.path(name)), content)
            if name == "a.1.vdb":
                self.assertEqual(os.stat(self.path(name)).st_mtime_ns, time)
        self.assertEqual(self.bake("--half"), [1, 2, 3])
        self.assertEqual(self.bake(), [1, 2, 3])

    def test_one_changed_frame_of_the_asset(self):
        self.assertEqual(self.bake(), [1, 2, 3])
        with open(ANIMATED) as file:
            asset = json.load(file)
        asset["forms"][0]["frames"]["2"][0] += 1e-9
        changed = self.path("changed.octet.json")
        with open(changed, "w") as file:
            json.dump(asset, file)
        self.assertEqual(self.bake(asset=changed), [2])

    def test_parts_are_told_from_wholes(self):
        whole, part = self.path("w.vdb"), self.path("p.vdb")
        def bake(out, *options):
            report = json.loads(self.succeed("bake", BOX, "--resolution", "16", "--skip-existing", "-o",
                                             out, "--json", *options))
            return not report["files"][0].get("skipped")
        self.assertTrue(bake(whole))
        self.assertTrue(bake(part, "--shard", "1/2"))
        self.assertFalse(bake(part, "--shard", "1/2"))
        self.assertTrue(bake(part, "--shard", "2/2"))
        self.assertTrue(bake(part, "--region", 0, 0, 0, 1, 1, 1))
        self.assertFalse(bake(part, "--region", 0, 0, 0, 1, 1, 1))
        self.assertTrue(bake(part, "--region", 0, 0, 0, 1, 1, 0.5))
        self.assertTrue(bake(part))
        self.assertFalse(bake(whole))

    def test_merged_shards_are_there(self):
        whole = self.path("w.vdb")
        for shard in (1, 2):
            self.succeed("bake", BOX, "--resolution", "16", "-o", self.path(f"p{shard}.vdb"), "--shard",
                         f"{shard}/2")
        self.succeed("merge", self.path("p1.vdb"), self.path("p2.vdb"), "-o", whole)
        merged = digest(whole)
        said = self.succeed("bake", BOX, "--resolution", "16", "--skip-existing", "-o", whole)
        self.assertIn("is there", said)
        self.succeed("bake", BOX, "--resolution", "16", "-o", whole)
        self.assertEqual(digest(whole), merged)

    def test_it_says_so(self):
        self.bake()
        said = self.succeed(*SMALL, "--frames", "1-3", "-o", self.path("a.#.vdb"), "--skip-existing")
        self.assertEqual(said.count("is there, from the same asset and options"), 3)


class Progress(Case):
    # A second or so of work, in many pieces.
    LONG = ("bake", ANIMATED, "--resolution", "36", "--frames", "1-4")

    def told(self, style, *more):
        result = OCTETVDB.run(*self.LONG, "-o", self.path("a.#.vdb"), "--progress", style, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout, result.stderr.splitlines()

    def test_plain_lines_for_logs(self):
        _, lines = self.told("plain")
        percents = [int(re.fullmatch(r"octetvdb: +(\d+) %  \S.*", line)[1]) for line in lines]
        self.assertEqual(percents, sorted(percents))
        self.assertGreaterEqual(len({p // 10 for p in percents}), 8)
        self.assertLess(len(percents), 40)

    def test_off_a_terminal_it_is_told_but_not_of_short_work(self):
        slow = OCTETVDB.run("bake", BOX, "--form", "velocity", "--resolution", "200", "-o",
                            self.path("a.vdb"), "--threads", "1", progress="auto")
        self.assertRegex(slow.stderr, r"octetvdb: +\d+ %  ")
        short = OCTETVDB.run("--version", progress="auto")
        self.assertEqual(short.stderr, "")

    def test_open_job_description(self):
        _, lines = self.told("openjd")
        percents = [float(line.split()[1]) for line in lines if line.startswith("openjd_progress: ")]
        self.assertEqual(percents, sorted(set(percents)))
        self.assertEqual(percents[-1], 100)
        self.assertIn("openjd_status: bake velocity", lines)
        self.assertTrue(all(re.match("openjd_(progress|status): ", line) for line in lines))
        failed = OCTETVDB.run("info", self.path("none.vdb"), "--progress", "openjd")
        self.assertEqual(failed.returncode, 2)
        self.assertIn("openjd_fail: ", failed.stderr)

    def test_alfred(self):
        _, lines = self.told("alfred")
        self.assertEqual(lines[-1], "ALF_PROGRESS 100%")
        self.assertTrue(all(re.fullmatch(r"ALF_PROGRESS \d+%", line) for line in lines))

    def test_json_beside_a_document(self):
        out, lines = self.told("json", "--json")
        self.assertEqual(len(json.loads(out)["files"]), 4)
        reports = [json.loads(line) for line in lines]
        fractions = [r["fraction"] for r in reports]
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1)
        self.assertLessEqual({"stage", "done", "total", "unit", "seconds"}, set(reports[0]))

    def test_none(self):
        self.assertEqual(self.told("none")[1], [])
        self.fail_with(2, 'did you mean "plain"?', "info", BOX, "--progress", "plan")


class Grants(Case):
    """What a farm grants: threads and memory."""

    def granted(self, environment, *options):
        said = self.succeed(*options, "--version", "--json", env={**os.environ, **environment})
        return json.loads(said)

    def test_threads(self):
        everything = self.granted({})["threads"]
        self.assertEqual(everything, len(os.sched_getaffinity(0)))
        self.assertEqual(self.granted({"SLURM_CPUS_PER_TASK": "3"})["threads"], 3)
        self.assertEqual(self.granted({"CUE_THREADS": "5"})["threads"], 5)
        self.assertEqual(self.granted({"CUE_THREADS": "5"}, "--threads", "2")["threads"], 2)
        self.assertEqual(self.granted({"CUE_THREADS": "1"}, "--threads", "7")["threads"], 7)
        for text in ("many", "0", "-1", ""):
            self.assertEqual(self.granted({"CUE_THREADS": text})["threads"], everything)
        self.assertEqual(self.granted({"SLURM_MEM_PER_NODE": "500"})["memory_bytes"], 500 * 2**20)

    def test_memory(self):
        for name, value in (("SLURM_MEM_PER_NODE", "40"), ("CUE_MEMORY", "40960")):
            result = self.fail_with(33, "memory", "bake", BOX, "--resolution", "100", "-o",
                                    self.path("a.vdb"), env={**os.environ, name: value})
            self.assertEqual(self.files(), [])
            self.assertEqual(result.stdout, "")

    def test_memory_that_runs_out_all_the_same(self):
        """An allocation that fails, though the plan's figure fits: the address space is all there is."""
        if OCTETVDB.sanitized:
            self.skipTest("address space cannot be limited")
        for megabytes in (300, 400, 600):
            result = subprocess.run(
                ["sh", "-c", f'ulimit -v {megabytes * 1024}; exec "$@"', "sh", OCTETVDB.path, "bake",
                 BOX, "--resolution", "150", "-o", self.path("a.vdb")], capture_output=True, text=True)
            self.assertIn(result.returncode, (0, 33), result.stderr)
            if result.returncode:
                self.assertEqual(self.files(), [])


class Json(Case):
    def error(self, code, *arguments, **options):
        result = OCTETVDB.run(*arguments, "--json", **options)
        self.assertEqual((result.returncode, result.stderr.count("\n")), (code, 1))
        error = json.loads(result.stdout)["error"]
        self.assertEqual(error["code"], code)
        self.assertEqual(result.stderr, f"octetvdb: {error['message']}\n")
        return error

    def test_errors_are_documents(self):
        out = self.path("a.vdb")
        missing = self.error(2, "info", self.path("none.vdb"))
        self.assertEqual((missing["kind"], missing["file"]), ("input", self.path("none.vdb")))
        self.assertIn("cannot be read", missing["reason"])
        self.assertEqual(self.error(2, "bake", BOX, "-o", out)["kind"], "input")
        usage = self.error(2, "bake", BOX, "-o", out, "--resolutoin", "8")
        self.assertEqual(usage["kind"], "usage")
        self.assertIn("--resolution", usage["message"])
        memory = self.error(33, "bake", BOX, "-o", out, "--voxel-size", "1e-9")
        self.assertEqual(memory["kind"], "memory")
        self.assertGreater(memory["needed_bytes"], memory["available_bytes"])
        self.assertEqual(self.error(1, "bake", BOX, "--resolution", "8", "-o",
                                    self.path("none/a.vdb"))["kind"], "io")
        self.assertEqual(self.files(), [])

    def test_a_limit_that_is_passed_is_in_the_one_document(self):
        out = self.path("a.vdb")
        self.succeed("bake", BOX, "--form", "velocity", "--resolution", "12", "-o", out)
        result = OCTETVDB.run("verify", out, "--max-divergence", "1e-12", "--json")
        self.assertEqual((result.returncode, result.stderr.count("\n")), (1, 1))
        document = json.loads(result.stdout)
        self.assertEqual(document["error"]["place"], "velocity")
        self.assertEqual(len(document["grids"]), 1)

    def test_versions(self):
        versions = json.loads(self.succeed("--version", "--json"))
        self.assertEqual(versions["octetvdb"] + "\n", self.succeed("--version"))
        for name in ("openvdb", "onetbb", "eigen", "assimp", "cli11"):
            self.assertRegex(versions["libraries"][name], r"^\d+\.\d+")

    def test_grids_that_were_meant(self):
        out = self.path("a.vdb")
        self.succeed("bake", BOX, "--form", "velocity", "--resolution", "12", "-o", out)
        self.fail_with(2, 'did you mean "velocity"?', "verify", out, "--grid", "velocty")
        self.fail_with(2, 'did you mean "velocity"?', "sample", BOX, out, "--grid", "velocty", "-o",
                       self.path("b.octet"))


class Reference(Case):
    def completed(self, *words):
        """What bash offers after these words."""
        with open(self.path("completion"), "w") as file:
            file.write(self.succeed("--reference", "bash"))
        line = " ".join(f'"{w}"' for w in words)
        script = (f'source {self.path("completion")}; COMP_WORDS=({line}); '
                  f'COMP_CWORD={len(words) - 1}; _octetvdb; printf "%s\\n" "${{COMPREPLY[@]}}"')
        done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def test_completion(self):
        self.assertIn("bake", self.completed("octetvdb", ""))
        self.assertEqual(self.completed("octetvdb", "ve"), ["verify"])
        self.assertEqual(self.completed("octetvdb", "bake", "--skip"), ["--skip-existing"])
        self.assertEqual(self.completed("octetvdb", "bake", "x", "--target", "ho"), ["houdini"])
        self.assertEqual(self.completed("octetvdb", "fill", "--cells", ""), ["lattice", "tetrahedra"])
        self.assertEqual(self.completed("octetvdb", "--progress", "op"), ["openjd"])
        self.assertEqual(self.completed("octetvdb", "info", ""), [])  # bash offers files

    def test_man_page(self):
        with open(self.path("octetvdb.1"), "w") as file:
            file.write(self.succeed("--reference", "man"))
        done = subprocess.run(["man", "--warnings", "-l", self.path("octetvdb.1")],
                              capture_output=True, text=True, env={**os.environ, "MANWIDTH": "100"})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for text in ("--skip-existing", "EXIT STATUS", "SLURM_CPUS_PER_TASK", "name.####.vdb", "openjd"):
            self.assertTrue(text in done.stdout, text)


if __name__ == "__main__":
    unittest.main()
