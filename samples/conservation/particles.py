#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a grid's divergence does to particles: 500 steps through a closed box, on three bakes of one
flow. Arguments: the commands octetvdb and advect, a folder for what is made, and --picture FILE.png.

The box has two stacked vortices (samples/box), and its walls lie on voxel faces. Particles start
evenly; an incompressible flow keeps them so. Reported is how many left the box, and the variance of
their number per cell of 3 x 3 x 3 voxels over its mean: 1 for particles thrown in at random. The picture needs Pillow.
"""
import argparse
import array
import json
import math
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

VOXELS = (33, 33, 51)  # odd: voxel 0 is centred at the origin
VOXEL = 2.0 / 33
SIZE = tuple(n * VOXEL for n in VOXELS)
CELL = 3  # voxels
LEVELS = ["--levels", "1"]  # fine cells are coarser than voxels: sampling shows its errors
BAKES = {
    "circulations": ["--grid", "staggered"],
    "face samples": ["--grid", "staggered", "--method", "samples"],
    "centre samples": ["--grid", "collocated", "--method", "samples"],
}


def potential(p):
    """Vanishes tangentially on the walls."""
    x, y, z = (math.pi * (p[k] / SIZE[k] + 0.5) for k in range(3))
    return (0.35 * math.sin(y) * math.sin(2 * z), 0.25 * math.sin(x) * math.sin(z),
            0.6 * math.sin(x) * math.sin(y) * math.cos(z))


def make_asset(path):
    cage = oa.box((4, 4, 6), SIZE)
    circulation = {e: 0.0 if e in cage.boundary_edges else cage.circulation(potential, e)
                   for e in cage.edges}
    oa.write(path, "particles", cage, [oa.form("potential", 1, "m^2/s", circulation)])


def bake(octetvdb, asset, out, options):
    result = subprocess.run([octetvdb, "bake", asset, "-o", out, "--d", "--voxel-size", str(VOXEL),
                             "--json", *LEVELS, *options], capture_output=True, text=True, check=True)
    return json.loads(result.stdout)["files"][0]["grids"][0]


def advect(advect_command, vdb, out, steps, count):
    low, high = [str(-s / 2) for s in SIZE], [str(s / 2) for s in SIZE]
    subprocess.run([advect_command, vdb, "potential", str(steps), "1", str(count), *low, *high, out],
                   check=True)
    numbers = array.array("f")
    with open(out, "rb") as file:
        numbers.frombytes(file.read())
    points = [tuple(numbers[k:k + 3]) for k in range(0, len(numbers), 3)]
    return points[:count], points[count:]


def dispersion(points):
    """Variance over mean of the number of points per cell; and how many points lie outside."""
    shape = [n // CELL for n in VOXELS]
    counts = [0] * (shape[0] * shape[1] * shape[2])
    outside = 0
    for p in points:
        at = [math.floor((p[k] + SIZE[k] / 2) / (CELL * VOXEL)) for k in range(3)]
        # A float step beyond the wall is on it.
        if any(abs(p[k]) > SIZE[k] / 2 * (1 + 1e-6) for k in range(3)):
            outside += 1
            continue
        at = [min(max(at[k], 0), shape[k] - 1) for k in range(3)]
        counts[(at[0] * shape[1] + at[1]) * shape[2] + at[2]] += 1
    mean = sum(counts) / len(counts)
    return sum((n - mean) ** 2 for n in counts) / len(counts) / mean, outside


def run(octetvdb, advect_command, folder, steps=500, count=30000):
    """Reports by bake: divergence, dispersion at start and end, particles outside; and end points."""
    asset = os.path.join(folder, "particles.octet.json")
    make_asset(asset)
    reports = {}
    for name, options in BAKES.items():
        vdb = os.path.join(folder, name.replace(" ", "_") + ".vdb")
        grid = bake(octetvdb, asset, vdb, options)
        start, end = advect(advect_command, vdb, vdb.replace(".vdb", ".bin"), steps, count)
        clumping, outside = dispersion(end)
        reports[name] = {"divergence_max": grid["certificate"]["divergence_max"],
                         "divergence_rms": grid["certificate"]["divergence_rms"],
                         "dispersion_start": dispersion(start)[0], "dispersion_end": clumping,
                         "outside": outside, "points": end}
    return reports


def draw(reports, path):
    """Particles near the middle plane y = 0, one panel for each bake."""
    from PIL import Image, ImageDraw
    scale, gap = 7, 14
    width, height = VOXELS[0] * scale, VOXELS[2] * scale
    image = Image.new("RGB", (3 * width + 4 * gap, height + 2 * gap + 34), "white")
    draw = ImageDraw.Draw(image)
    for panel, (name, report) in enumerate(reports.items()):
        left, top = gap + panel * (width + gap), gap
        for x, y, z in report["points"]:
            if abs(y) > 3 * VOXEL:
                continue
            u = left + (x / SIZE[0] + 0.5) * width
            v = top + (0.5 - z / SIZE[2]) * height
            draw.rectangle([u - 0.5, v - 0.5, u + 0.5, v + 0.5], fill=(20, 60, 120))
        draw.rectangle([left, top, left + width, top + height], outline=(170, 60, 40))
        draw.text((left, top + height + 4), f"{name}: max divergence "
                  f"{report['divergence_max']:.1g}", fill="black")
        draw.text((left, top + height + 18), f"variance/mean {report['dispersion_end']:.2f}, "
                  f"{report['outside']} outside", fill="black")
    image.quantize(16).save(path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("octetvdb")
    parser.add_argument("advect")
    parser.add_argument("folder")
    parser.add_argument("--count", type=int, default=30000)
    parser.add_argument("--picture")
    arguments = parser.parse_args()
    reports = run(arguments.octetvdb, arguments.advect, arguments.folder, count=arguments.count)
    for name, report in reports.items():
        print(name, json.dumps({k: v for k, v in report.items() if k != "points"}))
    if arguments.picture:
        draw(reports, arguments.picture)


if __name__ == "__main__":
    main()
