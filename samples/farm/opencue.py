#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bakes a sequence on OpenCue, with PyOutline: a layer of frames for each shard, and one that merges
them, frame by frame.

    opencue.py ASSET OUTPUT FRAMES [--shards N] [--threads N] [--memory 4g] [options of bake]

OUTPUT is such as /shots/tank/tank.####.vdb; OpenCue puts each frame's number into the command itself. A
frame that ends with code 33 had too little memory: OpenCue runs it again with more.
"""
import argparse
import getpass

import outline
import outline.cuerun
import outline.modules.shell


def make_outline(ours, bake):
    job = outline.Outline("octetvdb", show=ours.show, shot=ours.shot, user=getpass.getuser())
    resources = {"chunk": 1, "threads": ours.threads, "threadable": True, "range": ours.frames,
                 "memory": ours.memory}
    parts = [ours.output]
    if ours.shards > 1:
        parts = [ours.output.removesuffix(".vdb") + f".shard{k}of{ours.shards}.vdb"
                 for k in range(1, ours.shards + 1)]
    layers = []
    for shard, part in enumerate(parts, 1):
        command = ["octetvdb", "bake", ours.asset, "-o", part, *bake, "--frames", "#IFRAME#",
                   "--skip-existing"]
        if ours.shards > 1:
            command += ["--shard", f"{shard}/{ours.shards}"]
        layers.append(outline.modules.shell.Shell(f"bake{shard}", command=command, **resources))
        job.add_layer(layers[-1])
    if ours.shards > 1:
        names = [name.replace("####", "#ZFRAME#") for name in (*parts, ours.output)]
        merge = outline.modules.shell.Shell(
            "merge", command=["octetvdb", "merge", *names[:-1], "-o", names[-1]], **resources)
        for layer in layers:
            merge.depend_on(layer)
        job.add_layer(merge)
    return job


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("asset")
    parser.add_argument("output")
    parser.add_argument("frames")
    parser.add_argument("--shards", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--memory", default="4g")
    parser.add_argument("--show", default="testing")
    parser.add_argument("--shot", default="shot01")
    ours, bake = parser.parse_known_args()
    outline.cuerun.launch(make_outline(ours, bake), use_pycuerun=False)


if __name__ == "__main__":
    main()
