# SPDX-License-Identifier: Apache-2.0
"""A baked file or sequence as a Volume object."""
import os

import bpy

from .problems import Problem


def load(context, cage, files, frames):
    """Shows baked files in the place of the cage; replaces what an earlier bake showed.

    files: paths; frames: their numbers, or None for a single file
    """
    old = next((child for child in cage.children if child.get("octetvdb_volume")), None)
    data = bpy.data.volumes.new(f"{cage.name} Flow")
    data.filepath = files[0]
    data.velocity_unit = "SECOND"
    if frames is not None:
        data.is_sequence = True
        data.frame_duration = len(frames)
        data.frame_start = frames[0]
        # The file of frame f is numbered f: the first file's number, less the sequence's first.
        data.frame_offset = frames[0] - 1
    data.grids.load()
    if data.velocity_grid != "velocity":  # as it is by default; only a loaded grid can be named
        data.velocity_grid = "velocity"
    if old is not None:
        unused, old.data = old.data, data
        for material in unused.materials:
            data.materials.append(material)
        bpy.data.volumes.remove(unused)
        return old
    obj = bpy.data.objects.new(data.name, data)
    obj["octetvdb_volume"] = True
    obj.parent = cage
    for collection in cage.users_collection:
        collection.objects.link(obj)
    return obj


def absolute(path):
    """A .vdb path as the artist gave it, made absolute; without a .vdb ending it gets one."""
    if not path:
        raise Problem("Name the file to bake to")
    if path.startswith("//") and not bpy.data.filepath:
        raise Problem("Save the .blend first, or give the baked file an absolute path: "
                      f'"{path}" is beside the .blend')
    result = bpy.path.abspath(path)
    if not result.lower().endswith(".vdb"):
        result += ".vdb"
    return os.path.abspath(result)
