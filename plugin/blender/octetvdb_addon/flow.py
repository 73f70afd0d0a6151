# SPDX-License-Identifier: Apache-2.0
"""Operators that say what flows in a cage: guide curves, primitives, and the fit to them."""
import bpy
import numpy as np
from bpy.props import EnumProperty

from . import cage_mesh, current, flow_data, guides, library, primitives
from .action import Action
from .problems import Problem
from .properties import PRIMITIVES


def wall_options(cage, control):
    """Where the walls of a cage are closed, and whether its flow is to be divergence-free."""
    settings = cage.octetvdb
    boundary = control.complex.boundary_facets
    opened = np.empty(0, np.int32)
    if settings.walls == "OPEN":
        opened = boundary
    elif settings.walls == "GROUP":
        opened = cage_mesh.open_facets(cage, control, settings.open_group)
    return {"closed": np.setdiff1d(boundary, opened), "divergence_free": settings.divergence_free}


def fit_options(cage, control):
    """Arguments of octetvdb.Fit, as a cage's settings say."""
    settings, walls = cage.octetvdb, wall_options(cage, control)
    return {"kind": "divergence-free" if settings.divergence_free else "free",
            "closed_walls": settings.walls != "OPEN", "smoothness": settings.smoothness,
            "open_facets": np.setdiff1d(control.complex.boundary_facets, walls["closed"])}


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
    """Guides and primitives of a cage as the library takes them, now."""
    octetvdb = library.need()
    curves = [octetvdb.GuideCurve(name, points, speeds)
              for name, points, speeds in guides.library_guides(context, cage)]
    found = []
    for obj in primitives.objects(cage):
        if obj.octetvdb.primitive == "SOURCE" and cage.octetvdb.divergence_free:
            raise Problem(f'"{obj.name}" is a source: with Divergence-Free there can be none')
        found.append(primitives.in_cage(cage, obj))
    if not curves and not found:
        raise Problem(f'"{cage.name}" has no guides: select curves and use them as guides, or add '
                      "primitives")
    return curves, found


def solve(make_fit, control, gathered, walls, progress=None):
    """The flow of what `gather` found: fluxes, boundary mode, and the fit's report or None. Needs
    nothing of Blender's.

    make_fit: gives an octetvdb.Fit; asked only when there are guides
    """
    curves, found = gathered
    flux, report = np.zeros(control.complex.facet_count), None
    boundary = "walls" if len(walls["closed"]) else "open"
    if curves:
        result = make_fit().solve(curves, progress=progress)
        flux, boundary, report = flux + result.flux, result.boundary, result.report
    if found:
        flux += primitives.flux(control, found, walls["closed"], walls["divergence_free"])
    return flux, boundary, report


def describe(report):
    """How well guides are followed, one line each."""
    lines = [f"{guide.name}: {100 * guide.residual:.1f} % off" for guide in report.guides]
    lines += [f'"{c.first}" and "{c.second}" disagree' for c in report.conflicts]
    return "\n".join(lines + list(report.remarks))


class OCTETVDB_OT_use_guides(Action, bpy.types.Operator):
    """Make the selected curves the guides of the cage; their custom property "speed" tells how fast
    it flows along them"""
    bl_idname = "octetvdb.use_guides"
    bl_label = "Use Selected Curves"

    def run(self, context):
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


class OCTETVDB_OT_add_primitive(Action, bpy.types.Operator):
    """Add an empty at the 3D cursor whose flow adds to the cage's"""
    bl_idname = "octetvdb.add_primitive"
    bl_label = "Add Primitive"

    kind: EnumProperty(name="Kind", items=PRIMITIVES[1:])

    def run(self, context):
        cage = current.cage(context)
        label = next(item[1] for item in PRIMITIVES if item[0] == self.kind)
        obj = bpy.data.objects.new(label, None)
        obj.empty_display_type = "CIRCLE" if self.kind == "RING" else "SINGLE_ARROW"
        if self.kind in ("SOURCE", "NOISE"):
            obj.empty_display_type = "SPHERE"
        obj.location = context.scene.cursor.location
        obj.octetvdb.primitive = self.kind
        context.collection.objects.link(obj)
        cage.octetvdb.primitives.add().object = obj


class OCTETVDB_OT_fit(Action, bpy.types.Operator):
    """Find the flow that follows the guides best, and add the primitives'"""
    bl_idname = "octetvdb.fit"
    bl_label = "Fit"

    def run(self, context):
        cage = current.cage(context)
        control = cage_mesh.read(cage)
        options = fit_options(cage, control)
        flux, boundary, report = solve(lambda: _last_fit.get(control, options), control,
                                       gather(context, cage), wall_options(cage, control))
        flow_data.store(cage, flux, boundary)
        cage.octetvdb.flow_note = ""
        if report is not None:
            cage.octetvdb.flow_note = describe(report)
            for remark in report.remarks:
                self.report({"WARNING"}, remark)
            self.report({"INFO"}, f"Guides are followed to {100 * report.residual:.1f} %")


register, unregister = bpy.utils.register_classes_factory(
    (OCTETVDB_OT_use_guides, OCTETVDB_OT_add_primitive, OCTETVDB_OT_fit))
