#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Samples a fluid cache onto cages of several spacings, bakes it again on the cache's own voxels, and
prints the table of the README: sizes, error, divergence before and after.

    /usr/bin/python3 samples/cache/measure.py build/release/plugin/cli/octetvdb out/cache/data out/cache \
        [--cells 8 12 16] [--frame 20] [--step 5] [--obstacle]

Sizes count the velocity alone: each frame's grid is written to a file of its own, in 16 bits and
compressed as Blender does. Error and divergence are measured here, by numpy, on the voxels of one
frame; divergences are the same forward differences before and after.
"""
import argparse
import itertools
import json
import math
import pathlib
import re
import subprocess

import numpy as np
import pyopenvdb as vdb

# Mantaflow's velocities are voxels per its own unit of time, of which a second has 2.5 times the
# domain's time scale, whatever the frame rate (Blender's MANTA_main.cpp and fluid_script.h: a frame is
# 0.1 * 25 / fps * time_scale of them). Scale 2 is that of make_cache.py.
PER_SECOND = 2.5 * 2
MANTA = ["--velocity-unit", "voxels/s", "--scale", PER_SECOND]


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def array_of(grid, low, high):
    result = np.zeros(tuple(h - l + 1 for l, h in zip(low, high)) + (3,), np.float32)
    grid.copyToArray(result, ijk=low)
    return result.astype(float)


def divergence(v, voxel):
    """Forward differences on a staggered grid, without the last layer of each axis."""
    return sum(np.diff(v[..., k], axis=k)[:-1 if k != 0 else None, :-1 if k != 1 else None,
                                          :-1 if k != 2 else None] for k in range(3)) / voxel


def write_tank(path, box, voxel, rings=16):
    """The domain without the obstacle of make_cache.py, as a closed surface with a cavity."""
    # Voxels of the cache are centred half a voxel below where Blender has them.
    centre, radius = np.array((1.5, 1.5, 1.3)) - voxel / 2, 0.35
    points = [(box[3 * i], box[3 * j + 1], box[3 * k + 2])
              for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    around = 2 * rings
    top = len(points)
    points.append(centre + (0, 0, radius))
    for i in range(1, rings):
        for j in range(around):
            t, p = math.pi * i / rings, 2 * math.pi * j / around
            points.append(centre + radius * np.array((math.sin(t) * math.cos(p),
                                                      math.sin(t) * math.sin(p), math.cos(t))))
    bottom = len(points)
    points.append(centre - (0, 0, radius))

    def at(i, j):
        return top + 1 + (i - 1) * around + j % around

    for j in range(around):
        # Seen from the fluid: the ball inside out.
        faces += [(top, at(1, j + 1), at(1, j)), (bottom, at(rings - 1, j), at(rings - 1, j + 1))]
        faces += [(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j))
                  for i in range(1, rings - 1)]
    with open(path, "w") as file:
        file.writelines("v %.9f %.9f %.9f\n" % tuple(p) for p in points)
        file.writelines("f " + " ".join(str(v + 1) for v in f) + "\n" for f in faces)
    return centre, radius


def leak(asset, ball):
    """Largest flux through the obstacle's facets, relative to the largest of all."""
    document = json.loads(asset.read_text())
    x = np.array(document["vertices"])
    count = {}
    for cell in document["tetrahedra"]:
        for facet in itertools.combinations(sorted(cell), 3):
            count[facet] = count.get(facet, 0) + 1
    for o in document["octahedra"]:
        for facet in itertools.product((o[0], o[5]), (o[1], o[3]), (o[2], o[4])):
            facet = tuple(sorted(facet))
            count[facet] = count.get(facet, 0) + 1
    form = document["forms"][0]
    flux = {tuple(sorted(s)): abs(v) for s, v in zip(form["simplices"], form["values"])}
    centre, radius = ball
    walls = [f for f, n in count.items() if n == 1
             and np.linalg.norm(x[list(f)].mean(axis=0) - centre) < 1.2 * radius]
    assert walls
    return max(flux[f] for f in walls) / max(flux.values())


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def centred(v):
    """Vectors at voxel centres, without the last layers."""
    return np.stack([(v[:-1, :-1, :-1, 0] + v[1:, :-1, :-1, 0]) / 2,
                     (v[:-1, :-1, :-1, 1] + v[:-1, 1:, :-1, 1]) / 2,
                     (v[:-1, :-1, :-1, 2] + v[:-1, :-1, 1:, 2]) / 2], -1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("octetvdb", type=pathlib.Path)
    parser.add_argument("cache", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--cells", type=int, nargs="+", default=[8, 12, 16],
                        help="lattice edges along the domain")
    parser.add_argument("--corrections", type=int, nargs="+", default=[0, 4])
    parser.add_argument("--frame", type=int, help="at which to measure; the last by default")
    parser.add_argument("--step", type=int, default=1,
                        help="take every n-th frame alone, counted from the last")
    parser.add_argument("--obstacle", action="store_true",
                        help="leave the obstacle out of the cages, its walls closed; one frame")
    parser.add_argument("--pictures", action="store_true")
    options = parser.parse_args()
    octetvdb, out = options.octetvdb.resolve(), options.out
    out.mkdir(parents=True, exist_ok=True)
    files = sorted(options.cache.glob("fluid_data_*.vdb"))[::-options.step][::-1]
    if options.obstacle:
        files = files[-1:]
    numbers = {int(re.search(r"(\d+)\.vdb$", f.name).group(1)): f for f in files}
    frame = options.frame or max(numbers)
    velocity_bytes = 0
    for number, file in numbers.items():
        alone = out / f"velocity.{number:04d}.vdb"
        grid = vdb.read(str(file), "velocity")
        grid.saveFloatAsHalf = True
        vdb.write(str(alone), grid)
        velocity_bytes += alone.stat().st_size
    source = vdb.read(str(numbers[frame]), "velocity")
    low, high = source.evalActiveVoxelBoundingBox()
    voxel = source.transform.voxelSize()[0]
    # Staggered faces reach from half a voxel before the first centre.
    box = [(l - 0.5) * voxel for l in low] + [(h + 0.5) * voxel for h in high]
    side = box[3] - box[0]
    before = array_of(source, low, high) * voxel * PER_SECOND
    speed = rms(np.linalg.norm(centred(before), axis=-1))
    print(f"{len(files)} frames of {'x'.join(str(h - l + 1) for l, h in zip(low, high))} voxels, "
          f"velocity alone {velocity_bytes / 1e6:.1f} MB, all grids "
          f"{sum(f.stat().st_size for f in files) / 1e6:.1f} MB; frame {frame}: rms speed "
          f"{speed:.3g} m/s, rms divergence {rms(divergence(before, voxel)) * voxel / speed:.3g} "
          f"of speed / voxel\n")
    print("| lattice edge | cells | corrections | asset | ratio | error | divergence before "
          "| after, grid | after, form |")
    print("|---|---|---|---|---|---|---|---|---|")
    rows = []
    for cells, corrections in itertools.product(options.cells, options.corrections):
        cage, asset = out / f"cage_{cells}.octet.json", out / f"sampled_{cells}_{corrections}.octet"
        flux, boundary = "free", "auto"
        if options.obstacle:
            ball = write_tank(out / "tank.obj", box, voxel)
            asset, flux, boundary = asset.with_suffix(".octet.json"), "obstacles", "walls"
            run(octetvdb, "fill", out / "tank.obj", "--spacing", side / cells, "--fit-boundary",
                "-o", cage)
        else:
            run(octetvdb, "fill", "--box", *box, "--spacing", side / cells, "-o", cage)
        info = json.loads(cage.read_text())
        report = json.loads(run(octetvdb, "sample", cage, *numbers.values(), *MANTA,
                                "--divergence-free", "--corrections", corrections,
                                "--boundary-flux", flux, "--compare", 50000, "-o", asset, "--json"))
        baked = out / f"baked_{cells}_{corrections}.vdb"
        frames = ["--frames", f"{frame}-{frame}"] if len(numbers) > 1 else []
        run(octetvdb, "bake", asset, "-o", baked, "--voxel-size", voxel, "--grid", "staggered",
            "--boundary", boundary, "--form", "velocity", *frames)
        if frames:
            baked = baked.with_name(f"{baked.stem}.{frame:04d}.vdb")
        grid = vdb.read(str(baked), "velocity")
        after = array_of(grid, low, high)
        inside = np.linalg.norm(centred(after), axis=-1) > 0
        error = rms(np.linalg.norm((centred(after) - centred(before))[inside], axis=-1)) / speed
        left = divergence(after, voxel)
        # Faces outside the cage hold nothing: keep to voxels all of whose faces are baked.
        full = np.all(np.abs(after) > 0, axis=-1)
        full = full[:-1, :-1, :-1] & full[1:, :-1, :-1] & full[:-1, 1:, :-1] & full[:-1, :-1, 1:]
        row = {"cells": len(info["tetrahedra"]) + len(info["octahedra"]), "edge": side / cells,
               "bytes": asset.stat().st_size, "ratio": velocity_bytes / asset.stat().st_size,
               "error": error, "before": rms(divergence(before, voxel)) * voxel / speed,
               "after": rms(left[full]) * voxel / speed,
               "form": max(f["after"] for f in report["frames"]),
               "seconds": report["seconds"]}
        if options.obstacle:
            row["leak"] = leak(asset, ball)
        rows.append(row)
        print(f"| {row['edge'] / voxel:.1f} voxels | {row['cells']:,} | {corrections} "
              f"| {row['bytes'] / 1e6:.2f} MB "
              f"| 1 : {row['ratio']:.1f} | {100 * error:.1f} % | {row['before']:.2g} "
              f"| {row['after']:.2g} | {row['form']:.1g} |"
              + (f" flux through the obstacle {row['leak']:.1g}" if options.obstacle else ""),
              flush=True)
    (out / "measured.json").write_text(json.dumps(rows, indent=1))
    if options.pictures:
        # Half of the largest speed, in m/s and in the cache's units.
        top = float(np.abs(before).max()) / 2
        middle = (box[1] + box[4]) / 2
        for name, file, scale in (("cache", out / f"velocity.{frame:04d}.vdb", voxel * PER_SECOND),
                                  ("baked", baked, 1)):
            run(octetvdb, "preview", file, "--slice", f"y={middle}", "--range", f"0,{top / scale}",
                "-o", out / f"{name}.png", "--width", 560, "--height", 480, "--title", name)


main()
