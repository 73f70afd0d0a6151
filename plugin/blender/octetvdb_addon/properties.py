# SPDX-License-Identifier: Apache-2.0
"""What the add-on stores in the .blend: settings of the scene, of each cage, of each primitive."""
import bpy
from bpy.props import (BoolProperty, CollectionProperty, EnumProperty, FloatProperty,
                       IntProperty, PointerProperty, StringProperty)

from . import cage_mesh

PRIMITIVES = (
    ("NONE", "None", "An ordinary empty"),
    ("UNIFORM", "Uniform", "A flow along the empty's Z axis"),
    ("ROTATION", "Rotation", "A rigid rotation about the empty's Z axis"),
    ("VORTEX", "Vortex", "A vortex line along the empty's Z axis"),
    ("RING", "Vortex Ring", "A vortex ring in the empty's XY plane, as large as it is scaled"),
    ("SOURCE", "Source", "A source at the empty; a sink if its strength is negative"),
    ("NOISE", "Curl Noise", "Turbulence with details as large as the empty"),
)


def _is_cage(_, obj):
    return cage_mesh.is_cage(obj)


class OctetReference(bpy.types.PropertyGroup):
    object: PointerProperty(type=bpy.types.Object)


class OctetObject(bpy.types.PropertyGroup):
    """Of a cage: what flows in it and how it is baked. Of an empty: the primitive it is."""
    # Flow
    guides: CollectionProperty(type=OctetReference)
    primitives: CollectionProperty(type=OctetReference)
    walls: EnumProperty(
        name="Walls", default="CLOSED",
        items=(("CLOSED", "Closed", "Nothing flows through the boundary"),
               ("OPEN", "Open", "The flow may pass the boundary everywhere"),
               ("GROUP", "Open Group", "The flow may pass faces of one material or vertex group")))
    open_group: StringProperty(
        name="Open Group",
        description="Material or vertex group of the cage's faces that the flow may pass")
    divergence_free: BoolProperty(
        name="Divergence-Free", default=True,
        description="Keep the flow exactly incompressible")
    smoothness: FloatProperty(
        name="Smoothness", default=0.01, min=0, soft_max=0.2, precision=3,
        description="Details smaller than this share of the cage's size are smoothed away")
    flow_note: StringProperty(description="How well the last fit follows its guides")
    # Preview
    preview_levels: IntProperty(name="Levels", default=1, min=0, max=4,
                                description="Subdivisions for the preview")
    arrow_count: IntProperty(name="Arrows", default=400, min=0, soft_max=5000)
    streamline_count: IntProperty(name="Streamlines", default=60, min=0, soft_max=1000)
    # Bake
    size_mode: EnumProperty(
        name="Size", default="RESOLUTION",
        items=(("RESOLUTION", "Resolution", "Voxels along the longest side"),
               ("VOXEL", "Voxel Size", "Edge length of a voxel")))
    resolution: IntProperty(name="Resolution", default=64, min=1, soft_max=1024,
                            description="Voxels along the cage's longest side")
    voxel_size: FloatProperty(name="Voxel Size", default=0.1, min=1e-6, unit="LENGTH",
                              description="In the cage's own units")
    use_frames: BoolProperty(
        name="Animated", default=False,
        description="Fit and bake every frame of a range, for guides that move")
    frame_first: IntProperty(name="First Frame", default=1, min=0)
    frame_last: IntProperty(name="Last Frame", default=24, min=0)
    half: BoolProperty(name="Half Floats", default=False, description="Store 16-bit floats")
    with_density: BoolProperty(
        name="Density", default=True,
        description='Add a grid "density" that is 1 in the cage, so that the viewport and renderers '
                    "show the volume")
    path: StringProperty(name="File", default="//flow.vdb", subtype="FILE_PATH",
                         description="The .vdb to write; name.####.vdb when animated")
    certificate: StringProperty(
        description="What OpenVDB's operators found in the last bake; divergence is times voxel size "
                    "over largest speed")
    # Primitive
    primitive: EnumProperty(name="Primitive", items=PRIMITIVES, default="NONE")
    strength: FloatProperty(
        name="Strength", default=1.0,
        description="Speed of a uniform flow or noise, angular velocity of a rotation, circulation "
                    "of a vortex, volume rate of a source; per second")
    core: FloatProperty(name="Core", default=0.1, min=0,
                        description="Radius of a vortex' core")
    seed: IntProperty(name="Seed", default=0, min=0)


class OctetScene(bpy.types.PropertyGroup):
    cage: PointerProperty(name="Cage", type=bpy.types.Object, poll=_is_cage,
                          description="The cage that the panel works on")
    spacing: FloatProperty(
        name="Spacing", default=0, min=0, unit="LENGTH",
        description="Edge length of the cage's cells; 0 takes an eighth of the longest side")
    fit_boundary: BoolProperty(
        name="Fit Boundary", default=True,
        description="Move the filled cage's boundary onto the surface")
    progress: FloatProperty(name="Progress", min=0, max=100, subtype="PERCENTAGE", options={"HIDDEN"})
    task: StringProperty(options={"HIDDEN"})


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (OctetReference, OctetObject, OctetScene))


def register():
    _register_classes()
    bpy.types.Object.octetvdb = PointerProperty(type=OctetObject)
    bpy.types.Scene.octetvdb = PointerProperty(type=OctetScene)


def unregister():
    del bpy.types.Scene.octetvdb
    del bpy.types.Object.octetvdb
    _unregister_classes()
