# SPDX-License-Identifier: Apache-2.0
"""The add-on as a whole: its module, saved files, switching off and on."""
import os

import bpy
import numpy as np

from .common import FOLDER, octetvdb, start_over, box_with_flow
from octetvdb_addon import cage_mesh, flow_data, volume
import octetvdb_addon


def check_module_is_the_bundled_one():
    assert octetvdb.__name__ == "octetvdb_addon.octetvdb", octetvdb.__name__
    manifest = os.path.join(os.path.dirname(octetvdb_addon.__file__), "blender_manifest.toml")
    import tomllib
    with open(manifest, "rb") as file:
        manifest = tomllib.load(file)
    assert manifest["version"] == ".".join(map(str, octetvdb_addon.bl_info["version"]))
    assert manifest["version"] == octetvdb.__version__


def check_files_survive_saving():
    """Cage, flow and settings are in the .blend; a path beside it is found."""
    cage = box_with_flow()
    flux, _ = flow_data.load(cage, cage_mesh.read(cage))
    cage.octetvdb.path = "//beside.vdb"
    blend = os.path.join(FOLDER, "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    start_over()
    bpy.ops.wm.open_mainfile(filepath=blend)
    cage = bpy.context.scene.octetvdb.cage
    assert np.array_equal(flow_data.load(cage, cage_mesh.read(cage))[0], flux)
    assert volume.absolute(cage.octetvdb.path) == os.path.join(FOLDER, "beside.vdb")
    bpy.ops.octetvdb.bake()
    assert os.path.exists(os.path.join(FOLDER, "beside.vdb"))


def check_it_can_be_disabled_and_enabled():
    bpy.ops.preferences.addon_disable(module="octetvdb_addon")
    assert not hasattr(bpy.types.Scene, "octetvdb")
    bpy.ops.preferences.addon_enable(module="octetvdb_addon")
    assert hasattr(bpy.types.Scene, "octetvdb")
