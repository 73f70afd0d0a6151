# SPDX-License-Identifier: Apache-2.0
"""Smoke from Blender's own fluid simulation, Mantaflow, cached as OpenVDB files:
    blender -b --factory-startup --python-exit-code 1 --python mantaflow.py -- FOLDER [RESOLUTION [FRAMES]]
Their velocity grids are then there for `octetvdb verify`."""
import sys

import bpy


def main(folder, resolution=32, frames=4):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames

    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(0, 0, -0.5))
    source = bpy.context.object
    source.modifiers.new("Fluid", "FLUID").fluid_type = "FLOW"
    flow = source.modifiers["Fluid"].flow_settings
    flow.flow_type, flow.flow_behavior = "SMOKE", "INFLOW"
    flow.use_initial_velocity, flow.velocity_coord = True, (1.0, 0.5, 2.0)

    bpy.ops.mesh.primitive_cube_add(size=2)
    domain = bpy.context.object
    domain.modifiers.new("Fluid", "FLUID").fluid_type = "DOMAIN"
    settings = domain.modifiers["Fluid"].domain_settings
    settings.domain_type = "GAS"
    settings.resolution_max = resolution
    settings.cache_directory = folder
    settings.cache_type = "ALL"
    settings.cache_data_format = "OPENVDB"
    settings.openvdb_data_depth = "32"
    settings.cache_frame_start, settings.cache_frame_end = 1, frames
    for side in ("back", "bottom", "front", "left", "right", "top"):
        setattr(settings, f"use_collision_border_{side}", True)
    bpy.ops.fluid.bake_all()


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1:]
    main(arguments[0], *map(int, arguments[1:]))
