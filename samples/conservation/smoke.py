#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Smoke that filled a closed box evenly, after 1500 steps through the grids of particles.py: one
sampled at voxel centres, as velocities usually are, and one of circulations. Arguments: the commands
octetvdb and advect, a folder for what is made, the picture. Needs numpy, Pillow and a DejaVu font.
"""
import argparse
import os

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import particles as box

PANELS = {"centre samples": "sampled at voxel centres", "circulations": "OctetVDB, staggered"}
COUNT, STEPS = 20000, 1500
SCALE, MARGIN = 9, 3  # pixels per voxel; voxels shown around the box
BLUR = 1.2  # voxels
DARK, SMOKE, WALL, OUTSIDE = (np.array(c, float) for c in ((14, 17, 26), (236, 240, 248),
                                                           (96, 110, 140), (255, 140, 50)))


def blurred(image, sigma):
    reach = np.arange(-int(3 * sigma), int(3 * sigma) + 1)
    kernel = np.exp(-reach**2 / (2 * sigma**2))
    kernel /= kernel.sum()
    for axis in (0, 1):
        image = np.apply_along_axis(np.convolve, axis, image, kernel, mode="same")
    return image


def pixels(points):
    """Rows and columns of points, seen along y."""
    x, z = points[:, 0] / box.VOXEL, points[:, 2] / box.VOXEL
    return (SCALE * (box.VOXELS[2] / 2 + MARGIN - z)).astype(int), \
        (SCALE * (box.VOXELS[0] / 2 + MARGIN + x)).astype(int)


def panel(points):
    """The smoke's density seen along y, over its mean at the start; points beside the box as dots."""
    shape = [SCALE * (box.VOXELS[k] + 2 * MARGIN) for k in (2, 0)]
    outside = (np.abs(points) > np.array(box.SIZE) / 2 * (1 + 1e-6)).any(axis=1)
    density, weight = np.zeros(shape), np.zeros(shape)
    np.add.at(density, pixels(points[~outside]), 1.0)
    walls = slice(SCALE * MARGIN, -SCALE * MARGIN)
    weight[walls, walls] = 1
    # Over the blurred box, so that walls do not look thin.
    density = blurred(density, BLUR * SCALE) / np.maximum(blurred(weight, BLUR * SCALE), 0.2)
    density *= weight * weight.sum() / len(points)
    image = DARK + (SMOKE - DARK) * np.clip(density / 2, 0, 1)[..., None] ** 1.3
    beside = (np.abs(points) > np.array(box.SIZE) / 2 * (1 + 1e-6))[:, [0, 2]].any(axis=1)
    rows, columns = pixels(points[beside])
    for dr in (0, 1):
        for dc in (0, 1):
            image[np.clip(rows + dr, 0, shape[0] - 1), np.clip(columns + dc, 0, shape[1] - 1)] = OUTSIDE
    return Image.fromarray(image.clip(0, 255).astype(np.uint8)), int(outside.sum())


def draw(results, path):
    font, small = (ImageFont.truetype("DejaVuSans.ttf", size) for size in (17, 14))
    images = {name: panel(np.array(points)) for name, (_, points) in results.items()}
    width, height = next(iter(images.values()))[0].size
    picture = Image.new("RGB", (len(images) * width, height + 70), tuple(DARK.astype(int)))
    pen = ImageDraw.Draw(picture)
    for k, (name, (image, outside)) in enumerate(images.items()):
        picture.paste(image, (k * width, 34))
        corners = [k * width + SCALE * MARGIN, 34 + SCALE * MARGIN,
                   (k + 1) * width - SCALE * MARGIN, 34 + height - SCALE * MARGIN]
        pen.rectangle(corners, outline=tuple(WALL.astype(int)))
        middle = (k + 0.5) * width
        pen.text((middle, 28), PANELS[name], font=font, fill=tuple(SMOKE.astype(int)), anchor="mm")
        label = f"divergence {results[name][0]:.1g}, {outside:,} of {COUNT:,} outside"
        pen.text((middle, height + 42), label, font=small, fill=tuple(SMOKE.astype(int)), anchor="mm")
    picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("octetvdb", "advect", "folder", "picture"):
        parser.add_argument(name)
    arguments = parser.parse_args()
    asset = os.path.join(arguments.folder, "smoke.octet.json")
    box.make_asset(asset)
    results = {}
    for name in PANELS:
        vdb = os.path.join(arguments.folder, f"smoke_{name.replace(' ', '_')}.vdb")
        grid = box.bake(arguments.octetvdb, asset, vdb, box.BAKES[name])
        _, end = box.advect(arguments.advect, vdb, vdb.replace(".vdb", ".bin"), STEPS, COUNT)
        results[name] = grid["certificate"]["divergence_max"], end
        clumping, outside = box.dispersion(end)
        print(f"{name}: variance / mean {clumping:.2f}, {outside} outside")
    draw(results, arguments.picture)


if __name__ == "__main__":
    main()
