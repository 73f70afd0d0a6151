# SPDX-License-Identifier: Apache-2.0
"""Operators that say what flows in a cage: guide curves, primitives, and the fit to them."""
import bpy
import numpy as np

from . import cage_mesh, current, flow_data, guides, library
from .problems import Problem, reported


def fit_options(cage, control):
    """Arguments of octetvdb.Fit, as a cage's settings say."""
    settings = cage.octetvdb
    options = {"kind": "divergence-free" if settings.divergence_free else "free",
               "closed_walls": settings.walls != "OPEN", "smoothness": settings.smoothness,
               "open_facets": None}
    if settings.walls == "GROUP":
        options["open_facets"] = cage_mesh.open_facets(cage, control, settings.open_group)
    return options


class _LastFit:
    """The fit made last: guides that are moved about in the same cage need no other."""

    def __init__(self):
        self._key = self._fit = None

    def get(self, control, options):
        key = [control.vertices, control.tetrahedra, control.octahedra, control.creases,
               control.corners, *options.values()]
        if self._key is None or not all(map(np.array_equal, key, self._key)):
            self._fit = library.need().Fit(control, **options)
            self._key = key
        return self._fit


_last_fit = _LastFit()


def gather(context, cage):
    """The guides of a cage as the library takes them, now."""
    octetvdb = library.need()
    found = guides.library_guides(context, cage)
    if not found:
        raise Problem(f'"{cage.name}" has no guides: select curves and use them as guides')
    return [octetvdb.GuideCurve(name, points, speeds) for name, points, speeds in found]


def describe(report):
    """How well guides are followed, one line each."""
    lines = [f"{guide.name}: {100 * guide.residual:.1f} % off" for guide in report.guides]
    lines += [f'"{c.first}" and "{c.second}" disagree' for c in report.conflicts]
    return "\n".join(lines + list(report.remarks))


class OCTETVDB_OT_use_guides(bpy.types.Operator):
    """Make the selected curves the guides of the cage; their custom property "speed" tells how fast
    it flows along them"""
    bl_idname = "octetvdb.use_guides"
    bl_label = "Use Selected Curves"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context):
        cage = current.cage(context)
        curves = [obj for obj in context.selected_objects
                  if obj.type == "CURVE" and "octetvdb_preview" not in obj]
        if not curves:
            raise Problem("Select curve objects to use as guides")
        cage.octetvdb.guides.clear()
        for obj in curves:
            cage.octetvdb.guides.add().object = obj
            if guides.SPEED not in obj:
                obj[guides.SPEED] = 1.0
        return {"FINISHED"}


class OCTETVDB_OT_fit(bpy.types.Operator):
    """Find the flow that follows the guides best"""
    bl_idname = "octetvdb.fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    @reported
    def execute(self, context):
        cage = current.cage(context)
        control = cage_mesh.read(cage)
        fit = _last_fit.get(control, fit_options(cage, control))
        result = fit.solve(gather(context, cage))
        flow_data.store(cage, result.flux, result.boundary)
        cage.octetvdb.flow_note = describe(result.report)
        for remark in result.report.remarks:
            self.report({"WARNING"}, remark)
        self.report({"INFO"}, f"Guides are followed to {100 * result.report.residual:.1f} %")
        return {"FINISHED"}


_CLASSES = (OCTETVDB_OT_use_guides, OCTETVDB_OT_fit)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
