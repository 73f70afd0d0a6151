# SPDX-License-Identifier: Apache-2.0
"""Operators that make cages: from the active mesh, or from a control asset in a file."""
import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import cage_mesh, flow_data, library
from .action import Action
from .problems import Problem

# Cells along the longest side of a cage whose spacing is not given.
_CELLS_ACROSS = 8


def surface(context, obj):
    """Vertices (n, 3) in world space and triangles (n, 3) of a mesh object with its modifiers."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        points = cage_mesh.positions(mesh)
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
    finally:
        evaluated.to_mesh_clear()
    to_world = np.array(obj.matrix_world)
    return points @ to_world[:3, :3].T + to_world[:3, 3], triangles.reshape(-1, 3)


class OCTETVDB_OT_make_cage(Action, bpy.types.Operator):
    """Make a cage of tetrahedra and octahedra from the active mesh"""
    bl_idname = "octetvdb.make_cage"
    bl_label = "Make Cage"

    shape: EnumProperty(
        name="Shape", default="FILL",
        items=(("FILL", "Fill", "Fill the closed surface with the regular lattice"),
               ("TETRAHEDRA", "Tetrahedra",
                "Fill the closed surface with tetrahedra, made by Gmsh; sharp edges become creases"),
               ("BOX", "Box", "A box around the mesh, with flat walls")))
    spacing: FloatProperty(name="Spacing", default=-1, min=-1,
                           description="Edge length of cells; -1 takes the panel's, 0 an eighth of "
                                       "the longest side")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def run(self, context):
        octetvdb = library.need()
        source = context.active_object
        if source is None or source.type != "MESH" or not source.select_get():
            raise Problem("Select a mesh object to make a cage from")
        points, triangles = surface(context, source)
        if not len(points):
            raise Problem(f'"{source.name}" has no vertices')
        low, high = points.min(axis=0), points.max(axis=0)
        settings = context.scene.octetvdb
        spacing = settings.spacing if self.spacing < 0 else self.spacing
        spacing = spacing or (high - low).max() / _CELLS_ACROSS
        if self.shape == "BOX":
            control = octetvdb.box_cage(low, high, spacing)
        elif self.shape == "TETRAHEDRA":
            control = octetvdb.fill_tetrahedra(points, triangles, spacing)
        else:
            control = octetvdb.fill_surface(points, triangles, spacing,
                                            fit_boundary=settings.fit_boundary)
        cage = cage_mesh.create(context, f"{source.name} Cage", control)
        self.report({"INFO"}, f'"{cage.name}" has {control.complex.cell_count} cells')


class OCTETVDB_OT_open_asset(Action, bpy.types.Operator, ImportHelper):
    """Open a control asset (*.octet.json, *.octet) as a cage with its flow"""
    bl_idname = "octetvdb.open_asset"
    bl_label = "Open Control Asset"

    filter_glob: StringProperty(default="*.octet.json;*.octet", options={"HIDDEN"})

    def run(self, context):
        octetvdb = library.need()
        asset = octetvdb.ControlAsset.read(self.filepath)
        cage = cage_mesh.create(context, asset.name or "Cage", asset.mesh)
        forms = [form for form in asset.forms if form.degree == 2]
        if forms:
            flow_data.store(cage, forms[0].coefficients())


register, unregister = bpy.utils.register_classes_factory(
    (OCTETVDB_OT_make_cage, OCTETVDB_OT_open_asset))
