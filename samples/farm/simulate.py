#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How long a sequence takes on a farm, by discrete events.

    simulate.py measure OCTETVDB              costs of this machine, as JSON
    simulate.py plan [--costs FILE] [options] a table: machines, hours, what the file server carries

A task waits for a slot, works, and writes its file: all that write share the file server, and each has
no more than its own link. Work is a start, refinement by cells (which every shard of a frame does
again, but for the share `--shared-cells`), voxels, and bytes. Merging reads all shards of a frame and
writes it again.
"""
import argparse
import heapq
import json
import os
import subprocess
import sys
import tempfile

SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")


class Farm:
    """Slots that tasks take in their order, and a file server that whoever writes shares."""

    def __init__(self, slots, link, server, latency=0.0):
        self.free, self.link, self.server, self.latency = slots, link, server, latency
        self.now, self.moved, self.busy = 0.0, 0.0, 0.0

    def run(self, tasks):
        """tasks: (seconds of work, bytes read before it, bytes written after). Returns seconds."""
        started, waiting = self.now, list(reversed(tasks))
        working, moving = [], []  # (end, number, bytes to write); [bytes left, then]
        count = 0
        while waiting or working or moving:
            while waiting and self.free > 0:
                self.free -= 1
                work, reads, writes = waiting.pop()
                if reads:
                    moving.append([reads, (work, writes)])
                else:
                    heapq.heappush(working, (self.now + self.latency + work, count, writes))
                count += 1
            rate = min(self.link, self.server / len(moving)) if moving else 0
            first = min((left for left, _ in moving), default=float("inf"))
            end = self.now + first / rate if moving else float("inf")
            step = min(end, working[0][0] if working else float("inf"))
            for transfer in moving:
                transfer[0] -= rate * (step - self.now)
                self.moved += rate * (step - self.now)
            self.busy += (step - self.now) * (rate * len(moving) / self.server if moving else 0)
            self.now = step
            for _, after in [t for t in moving if t[0] <= 1e-6 * rate]:
                if after is None:
                    self.free += 1
                else:
                    work, writes = after
                    heapq.heappush(working, (self.now + self.latency + work, count, writes))
                    count += 1
            moving = [t for t in moving if t[0] > 1e-6 * rate]
            while working and working[0][0] <= self.now:
                _, _, writes = heapq.heappop(working)
                if writes:
                    moving.append([writes, None])
                else:
                    self.free += 1
        return self.now - started


def bake_tasks(costs, frames, shards, cells, voxels, shared_cells):
    """Bakes of all shards of all frames."""
    own_cells = cells * (shared_cells + (1 - shared_cells) / shards)
    work = (costs["start"] + costs["per_cell"] * own_cells
            + costs["per_voxel"] * voxels / shards)
    return [(work, 0, costs["bytes_per_voxel"] * voxels / shards)] * (frames * shards)


def merge_tasks(costs, frames, voxels):
    whole = costs["bytes_per_voxel"] * voxels
    return [(costs["start"] + costs["merge_per_byte"] * whole, whole, whole)] * frames


def schedule(costs, frames, shards, slots, cells, voxels, link, server, latency=0.0,
             shared_cells=1.0):
    """Seconds, bytes that the server carried, and the share of the time that it was full."""
    farm = Farm(slots, link, server, latency)
    seconds = farm.run(bake_tasks(costs, frames, shards, cells, voxels, shared_cells))
    if shards > 1:
        seconds += farm.run(merge_tasks(costs, frames, voxels))
    return seconds, farm.moved, farm.busy / max(seconds, 1e-9)


def timed(*command):
    """Processor seconds of a command on one thread, and the document that it prints."""
    before = os.times()
    done = subprocess.run([*map(str, command), "--threads", "1", "--json", "--progress", "none"],
                          check=True, capture_output=True, text=True)
    after = os.times()
    return (after.children_user + after.children_system - before.children_user
            - before.children_system, json.loads(done.stdout))


def bake_once(octetvdb, out, levels, resolution, *more):
    """Processor seconds, cells and voxels of a bake of the box."""
    box = os.path.join(SAMPLES, "box", "box.octet.json")
    seconds, report = timed(octetvdb, "bake", box, "--form", "velocity", "--grid", "staggered",
                            "--levels", levels, "--resolution", resolution, "-o", out, *more)
    return seconds, report["cells"], report["files"][0]["grids"][0]["active_voxels"]


def merge_per_byte(octetvdb, folder):
    """Processor seconds of a merge, by the bytes of what comes out, less those of a small one."""
    took = {}
    for resolution in (24, 160):
        parts = [os.path.join(folder, f"part{k}.vdb") for k in (1, 2)]
        for k, part in enumerate(parts, 1):
            bake_once(octetvdb, part, 2, resolution, "--shard", f"{k}/2")
        whole = os.path.join(folder, "whole.vdb")
        seconds, _ = timed(octetvdb, "merge", *parts, "-o", whole)
        took[os.path.getsize(whole)] = seconds
    (small, first), (large, last) = sorted(took.items())
    return (last - first) / (large - small)


def measure(octetvdb):
    """Least squares of relative errors, over cells and voxels; the better of two runs each."""
    import numpy as np
    rows, seconds, size = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "a.vdb")
        for levels, resolution in ((1, 24), (3, 48), (3, 96), (4, 96), (3, 128), (2, 192), (4, 160),
                                   (3, 192)):
            runs = [bake_once(octetvdb, out, levels, resolution) for _ in range(2)]
            took, cells, voxels = min(runs)
            rows.append([1, cells, voxels])
            seconds.append(took)
            size.append(os.path.getsize(out))
        merging = merge_per_byte(octetvdb, folder)
    rows, weights = np.array(rows), 1 / np.array(seconds)
    solved = np.linalg.lstsq(rows * weights[:, None], np.ones(len(rows)), rcond=None)[0]
    start, per_cell, per_voxel = np.maximum(solved, 0)
    return {"start": round(float(start), 3), "per_cell": float(f"{per_cell:.3g}"),
            "per_voxel": float(f"{per_voxel:.3g}"), "merge_per_byte": float(f"{merging:.3g}"),
            "bytes_per_voxel": round(sum(size) / rows[:, 2].sum(), 2),
            "largest_relative_miss": round(float(np.abs(rows @ solved * weights - 1).max()), 3)}


def plan(ours, costs):
    voxels = ours.fill * ours.resolution ** 3
    cells = ours.cells
    whole = costs["bytes_per_voxel"] * voxels
    print(f"{ours.frames} frames of {voxels / 1e6:.0f} million voxels, {cells / 1e6:.0f} million cells, "
          f"{whole / 1e9:.1f} GB each")
    print("| machines | shards | hours | machine hours | GB/s on the server | full |")
    print("|---|---|---|---|---|---|")
    for machines in ours.machines:
        for shards in ours.shards:
            seconds, moved, full = schedule(
                costs, ours.frames, shards, machines * ours.slots, cells, voxels, ours.link * 1e9,
                ours.server * 1e9, ours.latency, ours.shared_cells)
            print(f"| {machines} | {shards} | {seconds / 3600:.2f} | "
                  f"{machines * seconds / 3600:.0f} | {moved / seconds / 1e9:.2f} | {100 * full:.0f} % |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    measured = commands.add_parser("measure", help="costs of this machine")
    measured.add_argument("octetvdb")
    planned = commands.add_parser("plan", help="a table of farms")
    planned.add_argument("--costs", default=os.path.join(os.path.dirname(__file__), "costs.json"))
    planned.add_argument("--frames", type=int, default=1000)
    planned.add_argument("--resolution", type=int, default=1024)
    planned.add_argument("--fill", type=float, default=0.44, help="share of the cube that is active")
    planned.add_argument("--cells", type=float, default=1.2e6, help="of the finest level")
    planned.add_argument("--machines", type=int, nargs="+", default=[1, 10, 100, 1000])
    planned.add_argument("--slots", type=int, default=1, help="tasks at once on a machine")
    planned.add_argument("--threads", type=float, default=1, help="how much faster than one thread")
    planned.add_argument("--shards", type=int, nargs="+", default=[1, 8])
    planned.add_argument("--shared-cells", type=float, default=1.0)
    planned.add_argument("--link", type=float, default=1.0, help="GB/s of a machine")
    planned.add_argument("--server", type=float, default=5.0, help="GB/s of the file server")
    planned.add_argument("--latency", type=float, default=1.0, help="seconds to start a task")
    ours = parser.parse_args()
    if ours.command == "measure":
        print(json.dumps(measure(ours.octetvdb), indent=1))
        return
    with open(ours.costs) as file:
        costs = json.load(file)
    for name in ("per_cell", "per_voxel"):
        costs[name] /= ours.threads
    plan(ours, costs)


if __name__ == "__main__":
    sys.exit(main())
