# SPDX-License-Identifier: Apache-2.0
"""The preview: arrows and streamlines of a cage's flow, as curve objects."""
import bpy
import numpy as np

from . import cage_mesh, current, flow_data, library
from .action import Action

# Shares of a cage's mean cell size: longest arrow, radius of a streamline, and of an arrow's length:
# its head.
_ARROW_LENGTH, _LINE_RADIUS, _HEAD = 0.8, 0.02, 0.25


class OCTETVDB_OT_preview(Action, bpy.types.Operator):
    """Draw the flow as arrows and streamlines"""
    bl_idname = "octetvdb.preview"
    bl_label = "Preview"

    @classmethod
    def poll(cls, context):
        return context.scene.octetvdb.cage is not None

    def run(self, context):
        octetvdb = library.need()
        cage = current.cage(context)
        settings = cage.octetvdb
        control = cage_mesh.read(cage)
        flux, boundary = flow_data.load(cage, control)
        refiner = octetvdb.Refiner(control, settings.preview_levels)
        field = refiner.field(2, flux, boundary)
        size = np.cbrt(control.cell_volumes.mean())
        _show(cage, "Arrows", arrows(octetvdb, field, settings.arrow_count, size), 0)
        lines = []
        if settings.streamline_count:
            lines = octetvdb.streamlines(field, settings.streamline_count)
        _show(cage, "Streamlines", lines, _LINE_RADIUS * size)


def arrows(octetvdb, field, count, size):
    """Polylines (5, 3) of arrows: tail, tip, and a head of two strokes. The fastest is as long as a
    cell."""
    if count == 0:
        return []
    points = octetvdb.spaced_points(field, count)
    vectors, _ = field.sample(points)
    speed = np.linalg.norm(vectors, axis=1)
    moving = speed > 0
    if not moving.any():
        return []
    points, vectors, speed = points[moving], vectors[moving], speed[moving]
    shaft = vectors * (_ARROW_LENGTH * size / speed.max())
    # Any direction across the arrow.
    axis = np.eye(3)[np.abs(vectors).argmin(axis=1)]
    side = np.cross(shaft, axis)
    side *= (np.linalg.norm(shaft, axis=1) / np.linalg.norm(side, axis=1))[:, None]
    tip, back = points + shaft / 2, _HEAD * shaft
    return np.stack([points - shaft / 2, tip, tip - back + _HEAD / 2 * side, tip,
                     tip - back - _HEAD / 2 * side], axis=1)


def _show(cage, what, lines, radius):
    """Replaces the curve of that name beside a cage."""
    name = f"{cage.name} {what}"
    old = next((child for child in cage.children if child.get("octetvdb_preview") == what), None)
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = radius
    curve.bevel_resolution = 1
    for line in lines:
        spline = curve.splines.new("POLY")
        spline.points.add(len(line) - 1)
        homogeneous = np.ones((len(line), 4), np.float32)
        homogeneous[:, :3] = line
        spline.points.foreach_set("co", homogeneous.ravel())
    if old is not None:
        unused, old.data = old.data, curve
        curve.materials.clear()
        for material in unused.materials:
            curve.materials.append(material)
        bpy.data.curves.remove(unused)
        return
    obj = bpy.data.objects.new(name, curve)
    obj["octetvdb_preview"] = what
    obj.parent = cage
    for collection in cage.users_collection:
        collection.objects.link(obj)


register, unregister = bpy.utils.register_classes_factory((OCTETVDB_OT_preview,))
