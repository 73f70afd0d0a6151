#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bakes a sequence on Slurm: an array of tasks, one a frame, or one a shard of a frame, and then a job
that merges the shards.

    submit.py [--frames LIST] [--shards N] [--octetvdb COMMAND] [--sbatch="OPTIONS"]
              ASSET -o OUTPUT [other options of bake]

What there is to bake, and the memory that it takes, a dry run says. Run it again when tasks are lost:
frames that are there are left.
"""
import argparse
import json
import math
import os
import shlex
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))


def planned(octetvdb, bake):
    """What a dry run says: files with frames, and memory."""
    done = subprocess.run([octetvdb, "bake", *bake, "--skip-existing", "--dry-run", "--json"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr.strip())
    return json.loads(done.stdout)


def sbatch(script, arguments, count, options, environment):
    """Sends an array off; returns its number."""
    exported = ",".join(["ALL", *environment])
    command = ["sbatch", "--parsable", f"--array=0-{count - 1}", f"--export={exported}", *options,
               os.path.join(HERE, script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True,
                          env={**os.environ, **environment})
    if done.returncode != 0:
        sys.exit(done.stderr.strip())
    return done.stdout.strip().split(";")[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--frames", help="such as 1-10, 1-10x2 or 1,3,7-9; all by default")
    parser.add_argument("-o", "--output", required=True, help="such as tank.####.vdb")
    parser.add_argument("--shards", type=int, default=1, help="tasks of one frame")
    parser.add_argument("--octetvdb", default="octetvdb", help="the command, on every node")
    parser.add_argument("--sbatch", default="", help="options of sbatch, such as \"-p render\"")
    ours, bake = parser.parse_known_args()
    frames = ["--frames", ours.frames] if ours.frames else []
    if not any(mark in ours.output for mark in "#@%$<"):
        ours.output = ours.output.removesuffix(".vdb") + ".####.vdb"
    plan = planned(ours.octetvdb, [*bake, "-o", ours.output, *frames])
    if any("frame" not in file for file in plan["files"]):
        sys.exit("the asset is not animated: bake it with one command")
    files = [file for file in plan["files"] if not file.get("skipped")]
    there = len(plan["files"]) - len(files)
    if there:
        print(f"{there} frames are there")
    if not files:
        return
    os.makedirs(os.path.dirname(os.path.abspath(ours.output)), exist_ok=True)
    environment = {"OCTETVDB": ours.octetvdb, "OCTETVDB_SHARDS": str(ours.shards),
                   "OCTETVDB_OUTPUT": ours.output,
                   "OCTETVDB_FRAMES": " ".join(str(file["frame"]) for file in files)}
    options = shlex.split(ours.sbatch)
    if not any(o.startswith("--mem") for o in options):
        options.append(f"--mem={math.ceil(plan['bytes'] / 1e6) + 200}M")
    array = sbatch("bake.sbatch", bake, len(files) * ours.shards, options, environment)
    print(f"array {array}: {len(files)} frames, {ours.shards} tasks each, {' '.join(options)}")
    if ours.shards > 1:
        merge = sbatch("merge.sbatch", [file["path"] for file in files], len(files),
                       [f"--dependency=afterok:{array}", *options], environment)
        print(f"array {merge}: merges them")


if __name__ == "__main__":
    main()
