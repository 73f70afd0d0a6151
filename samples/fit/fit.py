#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fields fitted to guide curves, in a creased box and in a bunny: makes the cages, the guides and the
fits, and prints the table of the README.

    /usr/bin/python3 samples/fit/fit.py build/release/plugin/cli/octetvdb out/fit [--pictures]

The bunny is a level set of ellipsoids, which OpenVDB turns into a surface mesh; `octetvdb fill` fills
both with lattice cells.
"""
import argparse
import json
import math
import pathlib
import subprocess

import numpy as np
import pyopenvdb as vdb

BOX = (2.0, 1.0, 1.0)
# Centre and half axes: belly, head, ears, tail.
ELLIPSOIDS = [((0, 0, 0), (1.0, 0.85, 0.95)), ((0, -0.45, 1.15), (0.62, 0.62, 0.6)),
              ((-0.42, -0.35, 1.95), (0.34, 0.3, 0.8)), ((0.42, -0.35, 1.95), (0.34, 0.3, 0.8)),
              ((0, 0.9, -0.35), (0.32, 0.32, 0.32))]

VIEWS = {"box": ("--style", "lic", "--slice", "y=0.5", "--width", 960, "--height", 540),
         "bunny": ("--view", "3d", "--style", "streamlines", "--cage", "none", "--no-mesh",
                   "--camera", "60,15", "--width", 720, "--height", 720)}


def circle(name, centre, radius, speed, axis=(0, 0, 1), count=48):
    """Anticlockwise around `axis`; closed."""
    axis = np.array(axis, float) / np.linalg.norm(axis)
    side = np.cross(axis, (1, 0, 0) if abs(axis[0]) < 0.9 else (0, 1, 0))
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    turns = [2 * math.pi * (k % count) / count for k in range(count + 1)]
    points = [tuple(np.array(centre) + radius * (math.cos(t) * side + math.sin(t) * up))
              for t in turns]
    return [(name, *map(float, p), speed) for p in points]


def box_guides():
    """Two cells that turn against each other, at three depths, as between warm and cold plates."""
    rows = []
    for depth in (0.25, 0.5, 0.75):
        for centre, sense in ((0.5, 1), (1.5, -1)):
            turns = [2 * math.pi * (k % 64) / 64 for k in range(65)]
            for t in turns:
                # A squared circle that follows the walls; the speed of the roll sin x sin y.
                c, s = math.cos(t), math.sin(sense * t)
                x = centre + 0.32 * math.copysign(abs(c) ** 0.8, c)
                z = 0.5 + 0.32 * math.copysign(abs(s) ** 0.8, s)
                speed = math.hypot(math.sin(math.pi * x) * math.cos(math.pi * z),
                                   math.cos(math.pi * x) * math.sin(math.pi * z))
                rows.append((f"roll {centre} at {depth}", x, depth, z, speed))
    return rows


def bunny_guides():
    """The belly turns one way, the head the other; up one ear's middle ring and the other's."""
    return (circle("belly low", (0, 0, -0.4), 0.5, 0.8) + circle("belly", (0, 0, 0), 0.55, 1.0)
            + circle("belly inner", (0, 0, 0), 0.3, 0.55)
            + circle("head", (0, -0.45, 1.25), 0.3, -0.8)
            + circle("left ear", (-0.42, -0.35, 2.1), 0.15, 0.5)
            + circle("right ear", (0.42, -0.35, 2.1), 0.15, -0.5))


def write_guides(path, rows):
    with open(path, "w") as file:
        file.write("curve,x,y,z,speed\n")
        for name, x, y, z, speed in rows:
            file.write(f"{name},{x:.6f},{y:.6f},{z:.6f},{speed:.6f}\n")


def write_bunny(path, voxel=0.05):
    """The union of the ellipsoids, a little rounded where they meet, as an OBJ."""
    low, high = np.array((-1.4, -1.4, -1.3)), np.array((1.4, 1.5, 3.0))
    count = np.ceil((high - low) / voxel).astype(int)
    x = np.stack(np.meshgrid(*[low[k] + voxel * np.arange(count[k]) for k in range(3)],
                             indexing="ij"), -1)
    total = np.zeros(count)
    for centre, axes in ELLIPSOIDS:
        # About the distance, near the surface.
        inside = (np.linalg.norm((x - centre) / axes, axis=-1) - 1) * min(axes)
        total += np.exp(-inside / 0.05)
    grid = vdb.FloatGrid()
    grid.copyFromArray((-0.05 * np.log(np.maximum(total, 1e-30))).astype(np.float32))
    grid.transform = vdb.createLinearTransform(
        [[voxel, 0, 0, 0], [0, voxel, 0, 0], [0, 0, voxel, 0], [*map(float, low), 1]])
    points, quads = grid.convertToQuads()
    with open(path, "w") as file:
        for p in points:
            file.write("v %.6f %.6f %.6f\n" % tuple(p))
        for q in quads:
            file.write("f %d %d %d %d\n" % tuple(v + 1 for v in q))


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def wall_flux(asset):
    """Largest coefficient on a boundary facet."""
    document = json.loads(asset.read_text())
    seen = {}
    for cell in document["tetrahedra"]:
        for k in range(4):
            facet = tuple(sorted(cell[:k] + cell[k + 1:]))
            seen[facet] = seen.get(facet, 0) + 1
    for o in document["octahedra"]:
        for a in (o[0], o[5]):
            for b in (o[1], o[3]):
                for c in (o[2], o[4]):
                    facet = tuple(sorted((a, b, c)))
                    seen[facet] = seen.get(facet, 0) + 1
    form = next(f for f in document["forms"] if f["name"] == "velocity")
    values = {tuple(sorted(s)): v for s, v in zip(form["simplices"], form["values"])}
    return max(abs(values.get(f, 0)) for f, n in seen.items() if n == 1)


def fit(octetvdb, out, name, guides):
    write_guides(out / f"{name}_guides.csv", guides)
    fitted = out / f"{name}.octet.json"
    report = json.loads(run(octetvdb, "fit", out / f"{name}_cage.octet.json", "--guides",
                            out / f"{name}_guides.csv", "-o", fitted, "--json"))
    report["stored_wall_flux"] = wall_flux(fitted)
    report["cells"] = sum(len(json.loads(fitted.read_text())[k])
                          for k in ("tetrahedra", "octahedra"))
    return report


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("octetvdb", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--pictures", action="store_true")
    options = parser.parse_args()
    octetvdb, out = options.octetvdb.resolve(), options.out
    out.mkdir(parents=True, exist_ok=True)
    run(octetvdb, "fill", "--box", 0, 0, 0, *BOX, "--spacing", 0.25, "-o",
        out / "box_cage.octet.json")
    write_bunny(out / "bunny.obj")
    run(octetvdb, "fill", out / "bunny.obj", "--spacing", 0.2, "--fit-boundary", "-o",
        out / "bunny_cage.octet.json")
    print("| cage | cells | unknowns | guide | samples | residual | worst |")
    print("|---|---|---|---|---|---|---|")
    worst = 0
    for name, guides in (("box", box_guides()), ("bunny", bunny_guides())):
        report = fit(octetvdb, out, name, guides)
        for guide in report["guides"]:
            print(f"| {name} | {report['cells']:,} | {report['unknowns']:,} | {guide['name']} "
                  f"| {guide['samples']} | {100 * guide['residual']:.2f} % "
                  f"| {100 * guide['worst']:.1f} % |")
            worst = max(worst, guide["residual"])
        print(f"| {name} | | | flux through walls {report['stored_wall_flux']:.1g}, divergence "
              f"{report['divergence']:.1g} of the largest flux | | | |")
        worst = max(worst, report["stored_wall_flux"])
        if options.pictures:
            run(octetvdb, "preview", out / f"{name}.octet.json", "-o", out / f"{name}.png",
                "--title", f"fitted to six curves: {name}", *VIEWS[name])
    if worst >= 0.05:
        raise SystemExit(f"a guide is missed by {100 * worst:.1f} %")


main()
