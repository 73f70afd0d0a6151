#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A bake for target blender, opened in the real Blender: it is centred, and its velocity is found.

Arguments: the octetvdb command. Runs itself again inside Blender (headless), where a Volume to Mesh
modifier measures the place of the density and the Volume data-block tells the velocity grid.
"""
import json
import os
import subprocess
import sys
import tempfile

SIZE = (2.0, 3.0, 1.5)
VOXEL = 0.1


def make_asset(path):
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples"))
    import octet_asset as oa
    cage = oa.box((2, 3, 2), SIZE)
    fluxes = {f: cage.flux(lambda p: (1.0, 0.0, 0.0), f) for f in cage.facets}
    ones = {(v,): 1.0 for v in range(len(cage.vertices))}
    oa.write(path, "blender", cage, [oa.form("flow", 2, "m/s", fluxes),
                                     oa.form("density", 0, "1", ones)])


def measure(path):
    """Inside Blender: opens the file as a Volume and prints what Blender sees of it."""
    import bpy
    bpy.ops.object.volume_import(filepath=path, files=[{"name": os.path.basename(path)}],
                                 directory=os.path.dirname(path))
    volume_object = bpy.context.object
    volume = volume_object.data
    volume.grids.load()
    mesh_object = bpy.data.objects.new("surface", bpy.data.meshes.new("surface"))
    bpy.context.collection.objects.link(mesh_object)
    modifier = mesh_object.modifiers.new("surface", "VOLUME_TO_MESH")
    modifier.object = volume_object
    modifier.grid_name = "density"
    modifier.threshold = 0.5
    modifier.resolution_mode = "GRID"
    evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = [evaluated.matrix_world @ v.co for v in evaluated.data.vertices]
    report = {"grids": {g.name: g.data_type for g in volume.grids},
              "velocity_grid": volume.velocity_grid,
              "min": [min(p[k] for p in points) for k in range(3)],
              "max": [max(p[k] for p in points) for k in range(3)],
              "error": volume.grids.error_message}
    print("MEASURED " + json.dumps(report))


def in_blender(path):
    result = subprocess.run(
        ["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", __file__,
         "--", path], capture_output=True, text=True)
    for line in result.stdout.splitlines():
        if line.startswith("MEASURED "):
            return json.loads(line[len("MEASURED "):])
    sys.exit("Blender failed:\n" + result.stdout[-2000:] + result.stderr[-2000:])


def bake(octetvdb, asset, out, target):
    subprocess.run([octetvdb, "bake", asset, "-o", out, "--voxel-size", str(VOXEL), "--target",
                    target], check=True, capture_output=True)


def main(octetvdb):
    with tempfile.TemporaryDirectory() as folder:
        asset = os.path.join(folder, "blender.octet.json")
        make_asset(asset)
        centres = {}
        for target in ("blender", "openvdb"):
            out = os.path.join(folder, target + ".vdb")
            bake(octetvdb, asset, out, target)
            seen = in_blender(out)
            assert not seen["error"], seen
            centres[target] = [(a + b) / 2 for a, b in zip(seen["min"], seen["max"])]
            if target == "blender":
                assert seen["grids"] == {"velocity": "VECTOR_FLOAT", "density": "FLOAT"}, seen
                assert seen["velocity_grid"] == "velocity", seen
                for k in range(3):
                    size = seen["max"][k] - seen["min"][k]
                    assert abs(size - SIZE[k]) < 1.5 * VOXEL, seen
        print("centres in Blender:", centres)
        # The box is centred at the origin; without the target it is drawn half a voxel off.
        for k in range(3):
            assert abs(centres["blender"][k]) < 0.02 * VOXEL, centres
            assert abs(centres["openvdb"][k] - VOXEL / 2) < 0.02 * VOXEL, centres


if __name__ == "__main__":
    if "--" in sys.argv:
        measure(sys.argv[sys.argv.index("--") + 1])
    else:
        main(sys.argv[1])
