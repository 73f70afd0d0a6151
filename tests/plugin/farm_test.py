#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""samples/farm on a real Slurm: an array whose tasks are killed at random moments and sent back ends in
the same bytes as one local bake, and a sequence that is half there is finished with nothing baked twice.
Skipped where Slurm cannot be started. Arguments: the octetvdb command.

OCTETVDB_FARM_LOG names a file for the log of the run, OCTETVDB_FARM_KILLS how many tasks are killed."""
import hashlib
import importlib.util
import os
import random
import re
import shutil
import sys
import tempfile
import time
import unittest

import command
import one_machine_slurm

OCTETVDB = command.from_arguments()
FARM = os.path.join(command.SAMPLES, "farm")
ASSET = os.path.abspath(os.path.join(command.SAMPLES, "animated", "animated.octet.json"))
KILLS = int(os.environ.get("OCTETVDB_FARM_KILLS", "8"))
TIME_LIMIT = 240
SLOTS = 2  # tasks at once


def digests(folder):
    found = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            found[name] = hashlib.sha256(file.read()).hexdigest()
    return found


class Farm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not one_machine_slurm.can_run():
            raise unittest.SkipTest("Slurm cannot be started here")
        cls.folder = tempfile.mkdtemp(prefix="octetvdb-slurm-")
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.slurm = one_machine_slurm.Slurm(os.path.join(cls.folder, "slurm"), cpus=SLOTS)
        try:
            cls.slurm.__enter__()
        except RuntimeError as error:
            raise unittest.SkipTest(f"Slurm does not start: {str(error)[-2000:]}")
        cls.addClassCleanup(cls.slurm.stop)

    def setUp(self):
        self.work = tempfile.mkdtemp(dir=self.folder)
        self.events = []

    def say(self, text):
        self.events.append(f"{time.strftime('%H:%M:%S')} {text}")

    def submit(self, name, *options):
        os.makedirs(os.path.join(self.work, name), exist_ok=True)
        said = self.slurm.run(
            sys.executable, os.path.join(FARM, "submit.py"), "--octetvdb", OCTETVDB.path,
            f"--sbatch=--output={self.work}/%A_%a.log --cpus-per-task=1 --mem=500M", ASSET, "-o",
            os.path.join(self.work, name, "tank.####.vdb"), *options, cwd=self.work)
        self.say(said.strip())
        return said

    def wait(self):
        deadline = time.monotonic() + TIME_LIMIT
        while self.slurm.tasks():
            self.assertLess(time.monotonic(), deadline, self.slurm.run("squeue", "-r"))
            time.sleep(0.2)

    def logs(self):
        text = ""
        for name in sorted(os.listdir(self.work)):
            if name.endswith(".log"):
                with open(os.path.join(self.work, name)) as file:
                    text += file.read()
        return text

    def local(self, *options):
        folder = os.path.join(self.work, "local")
        os.mkdir(folder)
        done = OCTETVDB.run("bake", ASSET, "-o", os.path.join(folder, "tank.####.vdb"), *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return digests(folder)

    def kill_some(self, random_numbers, count):
        """Kills tasks at random moments: by Slurm, which sends them back, or the process itself, which
        its script sends back. Returns how many were hit."""
        hit, deadline = 0, time.monotonic() + TIME_LIMIT
        while hit < count and self.slurm.tasks() and time.monotonic() < deadline:
            time.sleep(random_numbers.uniform(0.1, 1.6))
            running = self.slurm.tasks("RUNNING")
            if not running:
                continue
            task, _ = random_numbers.choice(running)
            if random_numbers.random() < 0.5:
                self.slurm.run("scontrol", "requeue", task, check=False)
                self.say(f"requeued {task}")
            else:
                pids = self.pids(task)
                if not pids:
                    continue
                os.kill(random_numbers.choice(pids), 9)
                self.say(f"killed the process of {task}")
            hit += 1
        return hit

    def pids(self, task):
        """The octetvdb processes of a task."""
        array, number = task.split("_")
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/environ", "rb") as file:
                    environment = file.read().split(b"\0")
                if os.readlink(f"/proc/{pid}/exe") != os.path.realpath(OCTETVDB.path):
                    continue
            except OSError:
                continue
            if {f"SLURM_ARRAY_JOB_ID={array}".encode(),
                    f"SLURM_ARRAY_TASK_ID={number}".encode()} <= set(environment):
                found.append(int(pid))
        return found

    def keep_log(self):
        path = os.environ.get("OCTETVDB_FARM_LOG")
        if path:
            with open(path, "a") as file:
                file.write("\n".join([self.id(), *self.events]) + "\n" + self.logs() + "\n")

    def test_an_array_that_is_shot_at_ends_in_the_same_bytes(self):
        options = ("--resolution", "64", "--frames", "1-12")
        self.submit("farm", *options)
        hit = self.kill_some(random.Random(7), KILLS)
        self.wait()
        self.say(f"{hit} killed")
        again = len(re.findall(r"run [2-9]:", self.logs()))
        self.say(f"{again} runs were second runs or later")
        self.keep_log()
        self.assertGreaterEqual(hit, min(3, KILLS), self.logs())
        self.assertGreater(again, 0, self.logs())
        self.assertEqual(digests(os.path.join(self.work, "farm")), self.local(*options), self.logs())

    def test_shards_that_are_shot_at_merge_to_the_same_bytes(self):
        options = ("--resolution", "48", "--levels", "2", "--frames", "1-4")
        said = self.submit("farm", *options, "--shards", "3")
        self.assertIn("4 frames, 3 tasks each", said)
        self.assertIn("merges them", said)
        hit = self.kill_some(random.Random(11), KILLS)
        self.wait()
        self.say(f"{hit} killed")
        self.keep_log()
        self.assertEqual(digests(os.path.join(self.work, "farm")), self.local(*options), self.logs())

    def latency(self):
        """Seconds that it takes here to start a task and to end it."""
        started = time.monotonic()
        self.slurm.run("sbatch", "--array=0-5", "--cpus-per-task=1", "--mem=100M", "--output=/dev/null",
                       "--wrap=true")
        self.wait()
        return (time.monotonic() - started) * SLOTS / 6

    def test_the_simulation_foresees_the_schedule(self):
        """By discrete events, of tasks as long as they were, and what Slurm takes to start one."""
        spec = importlib.util.spec_from_file_location("simulate", os.path.join(FARM, "simulate.py"))
        simulate = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(simulate)
        latency = self.latency()
        self.submit("farm", "--resolution", "64", "--frames", "1-7")
        started = time.monotonic()
        self.wait()
        took = time.monotonic() - started
        work = [float(s) for s in re.findall(r"^([\d.]+) s$", self.logs(), re.M)]
        self.assertEqual(len(work), 7)
        farm = simulate.Farm(SLOTS, link=1e9, server=1e9, latency=latency)
        foreseen = farm.run([(seconds, 0, 0) for seconds in work])
        self.say(f"7 tasks of {min(work):.1f} to {max(work):.1f} s, {latency:.1f} s to start one: "
                 f"simulated {foreseen:.1f} s, Slurm took {took:.1f} s")
        self.keep_log()
        self.assertLess(abs(foreseen / took - 1), 0.4)

    def test_the_page_s_commands(self):
        with open(os.path.join(FARM, "README.md")) as file:
            text = re.sub(r"\\\n\s*", "", file.read())
        lines = re.findall(r"^    (samples/farm/submit.py .*|squeue .*)$", text, re.M)
        self.assertEqual(len(lines), 2)
        os.symlink(os.path.abspath(command.SAMPLES), os.path.join(self.work, "samples"))
        environment = self.slurm.environment
        path = f"{os.path.dirname(OCTETVDB.path)}:{environment['PATH']}"
        self.slurm.environment = {**environment, "PATH": path}
        for line in lines:
            self.say(self.slurm.run("bash", "-c", line, cwd=self.work).strip())
        self.slurm.environment = environment
        self.wait()
        self.keep_log()
        self.assertEqual(sorted(os.listdir(os.path.join(self.work, "out"))),
                         [f"tank.000{frame}.vdb" for frame in range(1, 7)])

    def test_what_is_there_is_not_baked_twice(self):
        options = ("--resolution", "32")
        self.submit("farm", *options, "--frames", "1-6")
        self.wait()
        folder = os.path.join(self.work, "farm")
        before = {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)}
        self.assertEqual(len(before), 6)
        os.truncate(os.path.join(folder, "tank.0004.vdb"), 1000)
        said = self.submit("farm", *options, "--frames", "1-12")
        self.assertIn("5 frames are there", said)
        self.assertIn("7 frames, 1 tasks each", said)
        self.wait()
        self.keep_log()
        after = {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)}
        self.assertEqual(len(after), 12)
        del before["tank.0004.vdb"]
        self.assertEqual({name: after[name] for name in before}, before)
        self.assertNotIn("tasks", self.submit("farm", *options, "--frames", "1-12"))
        self.assertEqual(digests(folder), self.local(*options, "--frames", "1-12"))

    def test_a_task_without_memory_is_held(self):
        environment = dict(self.slurm.environment)
        self.slurm.environment.update(OCTETVDB=OCTETVDB.path, OCTETVDB_FRAMES="1", OCTETVDB_SHARDS="1",
                                      OCTETVDB_OUTPUT=os.path.join(self.work, "a.####.vdb"))
        job = self.slurm.run("sbatch", "--parsable", "--array=0-0", "--mem=30M",
                             f"--output={self.work}/%A_%a.log", os.path.join(FARM, "bake.sbatch"),
                             ASSET, "--resolution", "64").strip()
        self.slurm.environment = environment
        deadline = time.monotonic() + 60
        while "held state" not in self.slurm.run("squeue", "-h", "-r", "-o", "%r"):
            self.assertLess(time.monotonic(), deadline, self.logs())
            time.sleep(0.2)
        self.assertIn("memory", self.logs())
        self.slurm.run("scontrol", "update", f"job={job}_0", "MinMemoryNode=800")
        self.slurm.run("scontrol", "release", f"{job}_0")
        self.wait()
        self.keep_log()
        self.assertTrue(os.path.exists(os.path.join(self.work, "a.0001.vdb")), self.logs())


if __name__ == "__main__":
    unittest.main()
