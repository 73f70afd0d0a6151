# SPDX-License-Identifier: Apache-2.0
"""Cages from meshes, and their edits."""
import math
import os

import bpy
import numpy as np

from .common import FOLDER, swirl, start_over, expect_error, sphere, circle, box_with_flow
from octetvdb_addon import cage_mesh


def check_cage_from_mesh():
    start_over()
    ball = sphere(1.2)
    ball.location, ball.scale = (3, -1, 0.5), (1, 1, 1.5)
    bpy.context.view_layer.update()
    bpy.ops.octetvdb.make_cage(shape="FILL", spacing=0.4)
    cage = bpy.context.object
    assert cage is not ball and cage_mesh.is_cage(cage)
    assert bpy.context.scene.octetvdb.cage == cage and cage.display_type == "WIRE"
    control = cage_mesh.read(cage)
    assert len(control.octahedra) and len(control.tetrahedra)
    assert len(cage.data.edges) == control.complex.edge_count
    assert len(cage.data.polygons) == len(control.complex.boundary_facets)
    volume_of_ball = 4 / 3 * math.pi * 1.2**3 * 1.5
    assert abs(control.cell_volumes.sum() / volume_of_ball - 1) < 0.25
    centre = control.vertices.mean(axis=0)
    assert np.allclose(centre, ball.location, atol=0.15), centre
    # Blender's faces look outward.
    for face in list(cage.data.polygons)[::7]:
        assert face.normal.dot(face.center - ball.location) > 0


def check_tetrahedra_keep_sharp_edges():
    start_over()
    bpy.ops.mesh.primitive_cube_add(size=2)
    try:
        bpy.ops.octetvdb.make_cage(shape="TETRAHEDRA", spacing=0.8)
    except RuntimeError as e:
        assert "octetvdb-gmsh: is not installed" in str(e), e
        return
    control = cage_mesh.read(bpy.context.object)
    assert len(control.octahedra) == 0
    assert abs(control.cell_volumes.sum() - 8) < 1e-5
    ends = control.vertices[control.creases]
    assert abs(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() - 24) < 1e-5


def check_cage_keeps_creases_and_edits():
    start_over()
    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.ops.octetvdb.make_cage(shape="BOX", spacing=1.0)
    cage = bpy.context.object
    control = cage_mesh.read(cage)
    # The box' edges are creases, and sharp in Blender.
    on_edges = [(np.abs(control.vertices[list(e)]) > 0.99).all(axis=0).sum() >= 2
                for e in control.creases]
    assert len(control.creases) and all(on_edges)
    assert sum(e.crease == 1 for e in cage.data.edges) == len(control.creases)
    # What the artist changes arrives: a moved vertex, an edge that is sharp no more, a sharp vertex.
    moved = int(control.creases[0][0])
    cage.data.vertices[moved].co *= 1.25
    edge = next(e for e in cage.data.edges if e.crease > 0.5)
    edge.crease = 0
    face_vertex = int(next(v for v in control.complex.facets[control.complex.boundary_facets].ravel()
                           if v not in control.creases))
    cage.data.vertex_creases[0].data[face_vertex].value = 1
    changed = cage_mesh.read(cage)
    assert np.allclose(changed.vertices[moved], 1.25 * control.vertices[moved])
    assert len(changed.creases) == len(control.creases) - 1
    assert tuple(sorted(edge.vertices)) not in set(map(tuple, changed.creases.tolist()))
    assert changed.corners.tolist() == [face_vertex]


def check_cage_errors():
    start_over()
    expect_error("select a mesh", bpy.ops.octetvdb.make_cage)
    curve = circle("Curve", 1, 0, 1)
    swirl.select(curve)
    expect_error("select a mesh", bpy.ops.octetvdb.make_cage)
    bpy.ops.mesh.primitive_plane_add()
    expect_error("not closed", bpy.ops.octetvdb.make_cage, shape="FILL", spacing=0.5)
    ball = sphere(1.0)
    expect_error("spacing", bpy.ops.octetvdb.make_cage, shape="FILL", spacing=50)
    expect_error("cells", bpy.ops.octetvdb.make_cage, shape="BOX", spacing=1e-4)
    ball.select_set(False)
    expect_error("select a mesh", bpy.ops.octetvdb.make_cage)
    empty = swirl.link(bpy.data.objects.new("Nothing", bpy.data.meshes.new("Nothing")))
    swirl.select(empty)
    expect_error("no vertices", bpy.ops.octetvdb.make_cage)
    before = set(bpy.data.objects.keys())
    expect_error("cannot be read", bpy.ops.octetvdb.open_asset,
                 filepath=os.path.join(FOLDER, "missing.octet.json"))
    assert set(bpy.data.objects.keys()) == before, "a failed operator left objects"


def check_edited_topology_is_refused():
    cage = box_with_flow()
    import bmesh
    edit = bmesh.new()
    edit.from_mesh(cage.data)
    bmesh.ops.delete(edit, geom=[edit.verts[:][0]], context="VERTS")
    edit.to_mesh(cage.data)
    edit.free()
    swirl.select(cage)
    for operator in (bpy.ops.octetvdb.fit, bpy.ops.octetvdb.preview, bpy.ops.octetvdb.bake):
        expect_error("add and remove none", operator)
