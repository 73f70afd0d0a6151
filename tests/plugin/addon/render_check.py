# SPDX-License-Identifier: Apache-2.0
"""Renders samples/blender/swirl.py small and compares it with a picture that is known to be good.

Run by addon_test.py inside Blender. Arguments after "--": the add-on's zip, a folder, the golden
picture; with a further "update" it is replaced. Prints "DIFFERENCE mean largest-block".
"""
import os
import shutil
import sys

import bpy
import numpy as np

ZIP, FOLDER, GOLDEN, *UPDATE = sys.argv[sys.argv.index("--") + 1:]
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../../samples/blender"))
bpy.ops.preferences.addon_install(filepath=ZIP, overwrite=True)
bpy.ops.preferences.addon_enable(module="octetvdb_addon")
import swirl  # noqa: E402

BLOCK = 15  # pixels; divides both sides


def pixels(path):
    image = bpy.data.images.load(path)
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[:, :, :3]


cage = swirl.make_flow(os.path.join(FOLDER, "render.vdb"))
swirl.dress(cage)
for child in cage.children:  # where streamlines start depends on the last digits of the flow
    child.hide_render = child.type == "CURVE"
picture = os.path.join(FOLDER, "render.png")
swirl.render(picture, 240, 135, 32)
if UPDATE:
    shutil.copy(picture, GOLDEN)
difference = np.abs(pixels(picture) - pixels(GOLDEN))
height, width = difference.shape[:2]
blocks = difference.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean(axis=(1, 3, 4))
print(f"DIFFERENCE {difference.mean():.6f} {blocks.max():.6f} {pixels(picture).std():.6f}")
