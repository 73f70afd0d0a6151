# SPDX-License-Identifier: Apache-2.0
"""The panel "OctetVDB" in the 3D viewport's sidebar."""
import bpy

from . import cage_mesh, flow_data, guides, library, primitives


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "OctetVDB"


def _cage(context):
    """As current.cage, but None where there is none."""
    active = context.active_object
    if cage_mesh.is_cage(active):
        return active
    cage = context.scene.octetvdb.cage
    return cage if cage_mesh.is_cage(cage) else None


def _lines(layout, text, icon):
    column = layout.column(align=True)
    for line in text.splitlines():
        column.label(text=line, icon=icon)


class OCTETVDB_PT_cage(_Panel, bpy.types.Panel):
    bl_idname = "OCTETVDB_PT_cage"
    bl_label = "Cage"

    def draw(self, context):
        layout = self.layout
        if library.octetvdb is None:
            layout.label(text=library.missing, icon="ERROR")
            return
        settings = context.scene.octetvdb
        layout.use_property_split = True
        layout.prop(settings, "cage")
        layout.prop(settings, "spacing")
        layout.prop(settings, "fit_boundary")
        row = layout.row(align=True)
        row.operator("octetvdb.make_cage", text="Fill Mesh", icon="MESH_ICOSPHERE").shape = "FILL"
        row.operator("octetvdb.make_cage", text="Box", icon="MESH_CUBE").shape = "BOX"
        layout.operator("octetvdb.open_asset", icon="FILE_FOLDER")
        cage = _cage(context)
        if cage is not None:
            cells = (len(cage.data["octetvdb_tetrahedra"]) // 4
                     + len(cage.data["octetvdb_octahedra"]) // 6)
            layout.label(text=f"{cage.name}: {cells:,} cells", icon="MESH_DATA")


class _CagePanel(_Panel):
    @classmethod
    def poll(cls, context):
        return library.octetvdb is not None and _cage(context) is not None


class OCTETVDB_PT_flow(_CagePanel, bpy.types.Panel):
    bl_idname = "OCTETVDB_PT_flow"
    bl_label = "Flow"

    def draw(self, context):
        layout = self.layout
        cage = _cage(context)
        settings = cage.octetvdb
        layout.operator("octetvdb.use_guides", icon="CURVE_DATA")
        column = layout.column(align=True)
        for obj in guides.objects(cage):
            row = column.row()
            row.label(text=obj.name, icon="OUTLINER_OB_CURVE")
            if guides.SPEED in obj:
                row.prop(obj, f'["{guides.SPEED}"]', text="Speed")
        layout.operator_menu_enum("octetvdb.add_primitive", "kind", icon="EMPTY_AXIS")
        for obj in primitives.objects(cage):
            box = layout.column(align=True)
            box.label(text=obj.name, icon="EMPTY_AXIS")
            box.prop(obj.octetvdb, "strength")
            if obj.octetvdb.primitive in ("VORTEX", "RING", "SOURCE"):
                box.prop(obj.octetvdb, "core")
            if obj.octetvdb.primitive == "NOISE":
                box.prop(obj.octetvdb, "seed")
        layout.use_property_split = True
        layout.prop(settings, "walls")
        if settings.walls == "GROUP":
            layout.prop(settings, "open_group")
        layout.prop(settings, "divergence_free")
        layout.prop(settings, "smoothness")
        layout.operator("octetvdb.fit", icon="FORCE_FLUIDFLOW")
        if settings.flow_note:
            _lines(layout, settings.flow_note, "DOT")


class OCTETVDB_PT_preview(_CagePanel, bpy.types.Panel):
    bl_idname = "OCTETVDB_PT_preview"
    bl_label = "Preview"

    def draw(self, context):
        layout = self.layout
        cage = _cage(context)
        settings = cage.octetvdb
        layout.use_property_split = True
        layout.prop(settings, "arrow_count")
        layout.prop(settings, "streamline_count")
        layout.prop(settings, "preview_levels")
        row = layout.row()
        row.enabled = flow_data.exists(cage)
        row.operator("octetvdb.preview", icon="STROKE")


class OCTETVDB_PT_bake(_CagePanel, bpy.types.Panel):
    bl_idname = "OCTETVDB_PT_bake"
    bl_label = "Bake"

    def draw(self, context):
        layout = self.layout
        settings = _cage(context).octetvdb
        layout.use_property_split = True
        layout.prop(settings, "size_mode")
        layout.prop(settings, "resolution" if settings.size_mode == "RESOLUTION" else "voxel_size")
        layout.prop(settings, "use_frames")
        if settings.use_frames:
            row = layout.column(align=True)
            row.prop(settings, "frame_first")
            row.prop(settings, "frame_last")
        layout.prop(settings, "half")
        layout.prop(settings, "with_density")
        layout.prop(settings, "path")
        scene = context.scene.octetvdb
        layout.operator("octetvdb.bake", icon="RENDER_ANIMATION")
        if scene.task:
            if hasattr(layout, "progress"):  # Blender 4.0
                layout.progress(factor=scene.progress / 100, text=scene.task)
            else:
                layout.prop(scene, "progress", slider=True, text=scene.task)
            layout.label(text="Esc cancels")
        if settings.certificate:
            box = layout.box()
            box.label(text="Certificate", icon="CHECKMARK")
            _lines(box, settings.certificate, "NONE")


register, unregister = bpy.utils.register_classes_factory(
    (OCTETVDB_PT_cage, OCTETVDB_PT_flow, OCTETVDB_PT_preview, OCTETVDB_PT_bake))
