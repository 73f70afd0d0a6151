#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Open Job Description and the OpenCue outline of samples/farm: their tasks, run one after the other
by a small stand-in for the farm, end in the bytes of one local bake. And the simulation: by hand
where that can be done. Arguments: the octetvdb command."""
import hashlib
import importlib.util
import itertools
import os
import re
import subprocess
import sys
import types
import unittest

import yaml

import command

OCTETVDB = command.from_arguments()
FARM = os.path.abspath(os.path.join(command.SAMPLES, "farm"))
ASSET = os.path.abspath(os.path.join(command.SAMPLES, "animated", "animated.octet.json"))
PATH = f"{os.path.dirname(OCTETVDB.path)}:/usr/bin:/bin"
SHARDS = (1,) if "--shard " not in OCTETVDB.run("bake", "--help").stdout else (1, 3)


def digests(folder):
    found = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            found[name] = hashlib.sha256(file.read()).hexdigest()
    return found


def load(name, modules=()):
    """A script of samples/farm as a module, with others put in the place of what it imports."""
    sys.modules.update(modules)
    spec = importlib.util.spec_from_file_location(name.removesuffix(".py"), os.path.join(FARM, name))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Case(unittest.TestCase):
    def setUp(self):
        temporary = command.temporary_folder()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def run_task(self, arguments):
        done = subprocess.run(arguments, capture_output=True, text=True, cwd=self.folder,
                              env={**os.environ, "PATH": PATH})
        self.assertEqual(done.returncode, 0, (arguments, done.stderr))
        return done.stderr

    def local(self):
        folder = os.path.join(self.folder, "local")
        os.makedirs(folder, exist_ok=True)
        self.run_task([OCTETVDB.path, "bake", ASSET, "--resolution", "24", "--frames", "1-3", "-o",
                       os.path.join(folder, "tank.####.vdb")])
        return digests(folder)


class OpenJobDescription(Case):
    """As the specification reads: parameters, parameter spaces, embedded files, actions."""

    def filled(self, text, values):
        filled = re.sub(r"\{\{ *([\w.]+) *\}\}", lambda m: str(values[m[1]]), str(text))
        self.assertNotIn("{{", filled)
        return filled

    def span(self, text):
        numbers = []
        for part in text.split(","):
            first, last, step = re.fullmatch(r"(-?\d+)(?:-(-?\d+)(?::(\d+))?)?", part).groups()
            numbers += range(int(first), int(last or first) + 1, int(step or 1))
        return numbers

    def run_job(self, given):
        with open(os.path.join(FARM, "openjd.yaml")) as file:
            job = yaml.safe_load(file)
        self.assertEqual(job["specificationVersion"], "jobtemplate-2023-09")
        values = {f"Param.{p['name']}": given.get(p["name"], p.get("default"))
                  for p in job["parameterDefinitions"]}
        self.assertNotIn(None, values.values())
        done, said = set(), ""
        for step in job["steps"]:
            self.assertLessEqual({d["dependsOn"] for d in step.get("dependencies", [])}, done)
            space = step["parameterSpace"]["taskParameterDefinitions"]
            spans = [self.span(self.filled(p["range"], values)) for p in space]
            for numbers in itertools.product(*spans):
                task = {**values, **{f"Task.Param.{p['name']}": n for p, n in zip(space, numbers)}}
                for embedded in step["script"]["embeddedFiles"]:
                    path = os.path.join(self.folder, embedded["name"])
                    with open(path, "w") as file:
                        file.write(self.filled(embedded["data"], task))
                    task[f"Task.File.{embedded['name']}"] = path
                action = step["script"]["actions"]["onRun"]
                said += self.run_task([action["command"],
                                       *(self.filled(a, task) for a in action["args"])])
                os.remove(path)
            done.add(step["name"])
        return said

    def test_its_tasks_make_the_bytes_of_a_local_bake(self):
        local = self.local()
        for shards in SHARDS:
            with self.subTest(shards=shards):
                out = os.path.join(self.folder, f"out{shards}")
                os.mkdir(out)
                said = self.run_job({"Asset": ASSET, "Folder": out, "Name": "tank", "Frames": "1-3",
                                     "Shards": shards, "Options": "--resolution 24"})
                self.assertIn("openjd_progress: 100", said)
                made = {n: d for n, d in digests(out).items() if "shard" not in n}
                self.assertEqual(made, local)


class Layer:
    """PyOutline's Shell, as far as the outline uses it."""

    def __init__(self, name, **arguments):
        self.name, self.arguments, self.depends = name, arguments, []

    def depend_on(self, layer):
        self.depends.append(layer)


class OpenCue(Case):
    def job(self, *arguments):
        class Outline:
            def __init__(self, name, **_):
                self.layers = []

            def add_layer(self, layer):
                assert set(layer.depends) <= set(self.layers)
                self.layers.append(layer)

        launched = []
        outline = types.ModuleType("outline")
        outline.Outline = Outline
        outline.cuerun = types.ModuleType("outline.cuerun")
        outline.cuerun.launch = lambda job, **_: launched.append(job)
        outline.modules = types.ModuleType("outline.modules")
        outline.modules.shell = types.ModuleType("outline.modules.shell")
        outline.modules.shell.Shell = Layer
        module = load("opencue.py", {"outline": outline, "outline.cuerun": outline.cuerun,
                                     "outline.modules": outline.modules,
                                     "outline.modules.shell": outline.modules.shell})
        before, sys.argv = sys.argv, ["opencue.py", *arguments]
        try:
            module.main()
        finally:
            sys.argv = before
        return launched[0]

    def test_its_frames_make_the_bytes_of_a_local_bake(self):
        local = self.local()
        for shards in SHARDS:
            with self.subTest(shards=shards):
                out = os.path.join(self.folder, f"cue{shards}")
                os.mkdir(out)
                job = self.job(ASSET, os.path.join(out, "tank.####.vdb"), "1-3", "--shards",
                               str(shards), "--resolution", "24")
                self.assertEqual(len(job.layers), shards + (shards > 1))
                for layer in job.layers:
                    self.assertEqual(layer.arguments["range"], "1-3")
                    for frame in (1, 2, 3):
                        self.run_task([part.replace("#IFRAME#", str(frame))
                                       .replace("#ZFRAME#", f"{frame:04d}")
                                       for part in layer.arguments["command"]])
                self.assertEqual({n: d for n, d in digests(out).items() if "shard" not in n}, local)


class Simulation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.simulate = load("simulate.py")

    def seconds(self, tasks, slots, link=100.0, server=1000.0, latency=0.0):
        return self.simulate.Farm(slots, link, server, latency).run(tasks)

    def test_work_alone(self):
        self.assertAlmostEqual(self.seconds([(10, 0, 0)] * 4, 2), 20)
        self.assertAlmostEqual(self.seconds([(10, 0, 0)] * 5, 2), 30)
        self.assertAlmostEqual(self.seconds([(10, 0, 0)] * 4, 2, latency=1), 22)
        self.assertAlmostEqual(self.seconds([(30, 0, 0), (10, 0, 0), (10, 0, 0)], 2), 30)

    def test_writers_share_the_server(self):
        self.assertAlmostEqual(self.seconds([(10, 0, 500)], 1), 15)  # its own link
        self.assertAlmostEqual(self.seconds([(10, 0, 500)] * 20, 20), 20)  # 20 links of 50
        self.assertAlmostEqual(self.seconds([(0, 500, 500)], 1), 10)  # reads, then writes
        # One starts to write when the other is half way: 5 s alone, then both with half the server.
        self.assertAlmostEqual(
            self.seconds([(0, 0, 1000), (5, 0, 1000)], 2, link=100, server=100), 20)

    def test_shards_pay_where_machines_are_left_over(self):
        costs = {"start": 0, "per_cell": 1e-6, "per_voxel": 1e-6, "bytes_per_voxel": 0,
                 "merge_per_byte": 0}
        def hours(frames, shards, slots):
            return self.simulate.schedule(costs, frames, shards, slots, 1e6, 99e6, 1e9, 1e9)[0]
        self.assertAlmostEqual(hours(1, 1, 9), 100)
        self.assertAlmostEqual(hours(1, 9, 9), 12)  # cells are each shard's: 1 and 99 / 9
        self.assertLess(hours(90, 1, 9), hours(90, 9, 9))


if __name__ == "__main__":
    unittest.main()
