# SPDX-License-Identifier: Apache-2.0
"""A control mesh as a Blender mesh, and back.

The Blender mesh has all edges of the cage, so that it can be seen and edited, and its boundary facets
as faces, so that walls can be told apart by material or vertex group. The cells are kept as custom
properties of the mesh. Vertices may be moved and edges creased; adding or removing any is refused
when the cage is read.
"""
import bmesh
import bpy
import numpy as np

from . import library
from .problems import Problem

_TETRAHEDRA, _OCTAHEDRA = "octetvdb_tetrahedra", "octetvdb_octahedra"
_VERTICES = "octetvdb_vertices"
# An edge or vertex is sharp in Blender from 0 to 1, in a cage it is or is not.
_SHARP = 0.5


def is_cage(obj):
    return obj is not None and obj.type == "MESH" and _VERTICES in obj.data


def create(context, name, control):
    """A new wire object of a ControlMesh, made the scene's cage."""
    mesh = bpy.data.meshes.new(name)
    faces = control.complex.facets[control.complex.boundary_facets]
    inward = control.complex.outward_signs[control.complex.boundary_facets] < 0
    faces[inward] = faces[inward, ::-1]
    mesh.from_pydata(control.vertices.tolist(), control.complex.edges.tolist(), faces.tolist())
    mesh[_TETRAHEDRA] = control.tetrahedra.ravel()
    mesh[_OCTAHEDRA] = control.octahedra.ravel()
    mesh[_VERTICES] = len(control.vertices)
    _write_creases(mesh, control)
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    obj.display_type = "WIRE"
    obj.show_in_front = True
    obj.hide_render = True
    context.collection.objects.link(obj)
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    context.scene.octetvdb.cage = obj
    return obj


def read(obj):
    """The ControlMesh of a cage object, in the object's own space."""
    octetvdb = library.need()
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    mesh = obj.data
    if len(mesh.vertices) != mesh[_VERTICES]:
        raise Problem(f'"{obj.name}" had {mesh[_VERTICES]} vertices and now has '
                      f"{len(mesh.vertices)}: move a cage's vertices, but add and remove none")
    creases, corners = _read_creases(mesh)
    return octetvdb.ControlMesh(positions(mesh), _rows(mesh, _TETRAHEDRA, 4),
                                _rows(mesh, _OCTAHEDRA, 6), creases=creases, corners=corners)


def positions(mesh):
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(float)


def open_facets(obj, control, group):
    """Facets of the cage whose faces have a material or a vertex group of that name."""
    mesh = obj.data
    material = mesh.materials.find(group)
    vertex_group = obj.vertex_groups.get(group)
    if material < 0 and vertex_group is None:
        raise Problem(f'"{obj.name}" has no material and no vertex group "{group}"')
    chosen = []
    if material >= 0:
        chosen = [p.vertices for p in mesh.polygons if p.material_index == material]
    else:
        inside = {v.index for v in mesh.vertices
                  if any(g.group == vertex_group.index and g.weight > _SHARP for g in v.groups)}
        chosen = [p.vertices for p in mesh.polygons if inside.issuperset(p.vertices)]
    chosen = [tuple(vertices) for vertices in chosen]
    if any(len(vertices) != 3 for vertices in chosen):
        raise Problem(f'"{obj.name}" has faces that are no triangles of the cage')
    if not chosen:
        raise Problem(f'no face of "{obj.name}" has "{group}"')
    return control.facet_index(np.array(chosen))[0]


def _rows(mesh, key, columns):
    return np.array(mesh[key].to_list() if len(mesh[key]) else [], int).reshape(-1, columns)


def _has_crease_members():
    """Blender 4.0 made creases ordinary attributes."""
    return "crease" in bpy.types.MeshEdge.bl_rna.properties


def _write_creases(mesh, control):
    sharp_edges = np.zeros(len(mesh.edges), np.float32)
    ends = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", ends)
    index, _ = control.edge_index(ends.reshape(-1, 2))
    if len(control.creases):
        creased, _ = control.edge_index(control.creases)
        sharp_edges[np.isin(index, creased)] = 1
    sharp_vertices = np.zeros(len(mesh.vertices), np.float32)
    sharp_vertices[control.corners] = 1
    if not _has_crease_members():
        for name, domain, values in (("crease_edge", "EDGE", sharp_edges),
                                     ("crease_vert", "POINT", sharp_vertices)):
            mesh.attributes.new(name, "FLOAT", domain).data.foreach_set("value", values)
        return
    edit = bmesh.new()
    edit.from_mesh(mesh)
    on_edges, on_vertices = edit.edges.layers.crease.verify(), edit.verts.layers.crease.verify()
    for edge in edit.edges:
        edge[on_edges] = sharp_edges[edge.index]
    for vertex in edit.verts:
        vertex[on_vertices] = sharp_vertices[vertex.index]
    edit.to_mesh(mesh)
    edit.free()


def _read_creases(mesh):
    """Sharp edges as pairs of vertices, sharp vertices."""
    on_edges = np.zeros(len(mesh.edges), np.float32)
    on_vertices = np.zeros(len(mesh.vertices), np.float32)
    if _has_crease_members():
        mesh.edges.foreach_get("crease", on_edges)
        if len(mesh.vertex_creases):
            mesh.vertex_creases[0].data.foreach_get("value", on_vertices)
    else:
        for name, values in (("crease_edge", on_edges), ("crease_vert", on_vertices)):
            if name in mesh.attributes:
                mesh.attributes[name].data.foreach_get("value", values)
    ends = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)[on_edges > _SHARP], np.flatnonzero(on_vertices > _SHARP)
