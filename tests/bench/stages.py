# SPDX-License-Identifier: Apache-2.0
"""A table of core_bench's results: medians of repetitions, and two threads over one.

usage: stages.py RESULT.json...
"""
import json
import statistics
import sys

# What is to be reached on one thread, million a second, and by two threads over one.
TARGETS = {"build": 0.5, "apply_1_form": 10, "apply_2_form": 10}
TARGET_OF_TWO = 1.7


def load(paths):
    """{(mesh, stage): {threads: [runs]}}, and the unit of each stage."""
    runs, units = {}, {}
    for path in paths:
        with open(path) as file:
            for run in json.load(file)["benchmarks"]:
                if run["run_type"] != "iteration":
                    continue
                stage, mesh, size, threads = run["name"].split("/")[:4]
                of_stage = runs.setdefault((f"{mesh}/{size}", stage), {})
                of_stage.setdefault(int(threads.split(":")[1]), []).append(run)
                units[stage] = next(key for key in run if key.endswith("/s"))
    return runs, units


def main(paths):
    runs, units = load(paths)
    print("one thread by processor time; two over one by the wall clock; medians")
    for (mesh, stage), by_threads in sorted(runs.items()):
        unit = units[stage]
        # The counter is a rate by the wall clock.
        one = statistics.median(r[unit] * r["real_time"] / r["cpu_time"] for r in by_threads[1])
        wall = {n: statistics.median(r["real_time"] for r in by_threads[n]) for n in by_threads}
        target = f" (target {TARGETS[stage]:g})" if stage in TARGETS else ""
        print(f"{mesh:13} {stage:13} {one / 1e6:6.2f} M {unit}{target}", end="")
        if 2 in wall:
            print(f"; two threads {wall[1] / wall[2]:.2f} x (target {TARGET_OF_TWO})", end="")
        print()


if __name__ == "__main__":
    main(sys.argv[1:])
