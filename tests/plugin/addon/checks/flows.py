# SPDX-License-Identifier: Apache-2.0
"""Fits to guides, walls and primitives."""
import os

import bpy
import numpy as np

from .common import (
    FOLDER, swirl, start_over, expect_error, circle, box_with_flow, field_of, guide_points)
from octetvdb_addon import cage_mesh, flow_data
import octetvdb_addon


def check_fit_follows_two_guides():
    cage = box_with_flow()
    field = field_of(cage)
    for name, sign in (("Low", 1), ("High", -1)):
        points, speeds = guide_points(cage, name)
        assert np.allclose(speeds, 1)
        tangents = np.gradient(points, axis=0)[1:-1]
        tangents /= np.linalg.norm(tangents, axis=1)[:, None]
        values, inside = field.sample(points[1:-1])
        assert inside.all()
        along = np.einsum("ij,ij->i", values, tangents)
        assert (along > 0.8).all() and (along < 1.2).all(), (name, along.min(), along.max())
        # "High" has a negative speed: it flows the other way round.
        turn = np.cross(points[1:-1, :2], values[:, :2])
        assert (np.sign(turn) == sign).all()
    control = cage_mesh.read(cage)
    flux, boundary = flow_data.load(cage, control)
    assert boundary == "walls"
    assert not flux[control.complex.boundary_facets].any(), "walls leak"
    divergence = np.abs(control.complex.derivative(2, flux)).max()
    assert divergence < 1e-13 * np.abs(flux).max(), divergence
    assert "Low: " in cage.octetvdb.flow_note and "High: " in cage.octetvdb.flow_note


def check_a_moved_cage_takes_world_guides():
    """Guides count in world space: cage and guides moved and scaled together fit alike."""
    first = box_with_flow()
    flux, _ = flow_data.load(first, cage_mesh.read(first))
    cage = box_with_flow()
    for obj in (cage, bpy.data.objects["Low"], bpy.data.objects["High"]):
        obj.scale = (2, 2, 2)
        obj.rotation_euler = (0.3, -0.2, 1.0)
        obj.location = (5, 6, 7)
        if obj is not cage:
            obj["speed"] = 2 * obj["speed"]
    bpy.context.view_layer.update()
    bpy.ops.octetvdb.fit()
    moved, _ = flow_data.load(cage, cage_mesh.read(cage))
    assert np.allclose(moved, flux, atol=2e-5 * np.abs(flux).max()), np.abs(moved - flux).max()


def check_walls_by_group():
    cage = box_with_flow()
    swirl.select(cage)
    settings = cage.octetvdb
    settings.walls = "GROUP"
    settings.open_group = "Hole"
    expect_error("no material and no vertex group", bpy.ops.octetvdb.fit)
    group = cage.vertex_groups.new(name="Hole")
    expect_error("no face", bpy.ops.octetvdb.fit)
    ends = [v.index for v in cage.data.vertices if abs(v.co.z) > 0.99]
    group.add(ends, 1.0, "REPLACE")
    # A guide that runs out through both open ends.
    line = swirl.guide("Through", [(0, 0, -0.95), (0, 0, 0), (0, 0, 0.95)], 1.0)
    swirl.select(line)
    bpy.ops.octetvdb.use_guides()
    bpy.ops.octetvdb.fit()
    control = cage_mesh.read(cage)

    def through(axis):
        flux, _ = flow_data.load(cage, control)
        facets = control.complex.boundary_facets
        points = control.vertices[control.complex.facets[facets]]
        there = (np.abs(points[:, :, axis]) > 0.99).all(axis=1)
        outward = (flux * control.complex.outward_signs)[facets][there]
        low = points[there, 0, axis] < 0
        return outward[low].sum(), outward[~low].sum(), np.abs(outward).max()
    low, high, _ = through(2)
    assert high > 0.1 and abs(low + high) < 1e-12, (low, high)
    for axis in (0, 1):
        assert through(axis)[2] == 0, "a closed wall leaks"
    # The same by material.
    by_group, _ = flow_data.load(cage, control)
    cage.vertex_groups.clear()
    for name in ("Wall", "Hole"):
        cage.data.materials.append(bpy.data.materials.new(name))
    for face in cage.data.polygons:
        face.material_index = int(all(abs(cage.data.vertices[v].co.z) > 0.99
                                      for v in face.vertices))
    bpy.ops.octetvdb.fit()
    by_material, _ = flow_data.load(cage, control)
    assert np.array_equal(by_group, by_material)


def check_primitives_flow_in_the_cage():
    """A rotation and a uniform flow through open walls are the fields they say, also in a cage that
    is moved, turned and scaled; in closed walls their nearest flow leaks nothing."""
    cage = box_with_flow()
    cage.octetvdb.guides.clear()
    cage.octetvdb.walls = "OPEN"
    cage.scale, cage.rotation_euler, cage.location = (2, 2, 2), (0.4, 0.2, -0.3), (1, 2, 3)
    context = bpy.context
    context.scene.cursor.location = (1.2, 2.3, 2.9)
    bpy.ops.octetvdb.add_primitive(kind="ROTATION")
    bpy.ops.octetvdb.add_primitive(kind="UNIFORM")
    turning, uniform = (entry.object for entry in cage.octetvdb.primitives)
    turning.octetvdb.strength, uniform.octetvdb.strength = 1.5, 0.7
    turning.rotation_euler, uniform.rotation_euler = (0.5, 0, 0), (0, 1.0, 0)
    context.view_layer.update()
    bpy.ops.octetvdb.fit()
    control = cage_mesh.read(cage)
    flux, boundary = flow_data.load(cage, control)
    assert boundary == "open"
    # Of a linear field a facet's flux is that of the value in its middle.
    p, q, r = (control.vertices[control.complex.facets[:, k]] for k in range(3))
    middle, area = (p + q + r) / 3, np.cross(q - p, r - p) / 2
    place = np.array(cage.matrix_world)
    world = middle @ place[:3, :3].T + place[:3, 3]
    omega = 1.5 * np.array(turning.matrix_world)[:3, 2]
    velocity = np.cross(omega, world - np.array(turning.location)) + \
        0.7 * np.array(uniform.matrix_world)[:3, 2]
    expected = np.einsum("ij,ij->i", velocity @ np.linalg.inv(place[:3, :3]).T, area)
    assert np.allclose(flux, expected, atol=1e-5 * np.abs(expected).max()), \
        np.abs(flux - expected).max()
    cage.octetvdb.walls = "CLOSED"
    bpy.ops.octetvdb.fit()
    control = cage_mesh.read(cage)
    flux, boundary = flow_data.load(cage, control)
    assert boundary == "walls" and not flux[control.complex.boundary_facets].any()
    assert np.abs(control.complex.derivative(2, flux)).max() < 1e-12 * np.abs(flux).max()
    assert np.abs(flux).max() > 0.01
    # Guides and primitives add up.
    swirl.select(bpy.data.objects["Low"])
    low = bpy.data.objects["Low"]
    low.scale, low.rotation_euler, low.location = cage.scale, cage.rotation_euler, cage.location
    context.view_layer.update()
    bpy.ops.octetvdb.use_guides()
    bpy.ops.octetvdb.fit()
    both, _ = flow_data.load(cage, control)
    cage.octetvdb.primitives.clear()
    bpy.ops.octetvdb.fit()
    guided, _ = flow_data.load(cage, control)
    assert np.allclose(both, flux + guided, atol=1e-12)


def check_every_primitive_and_its_errors():
    cage = box_with_flow()
    cage.octetvdb.guides.clear()
    kinds = [item[0] for item in octetvdb_addon.properties.PRIMITIVES[1:]]
    for kind in kinds:
        cage.octetvdb.primitives.clear()
        bpy.ops.octetvdb.add_primitive(kind=kind)
        obj = cage.octetvdb.primitives[0].object
        obj.scale = (0.5, 0.5, 0.5)
        bpy.context.view_layer.update()
        if kind == "SOURCE":
            expect_error("divergence-free", bpy.ops.octetvdb.fit)
            cage.octetvdb.divergence_free, cage.octetvdb.walls = False, "OPEN"
        if kind == "UNIFORM":  # in closed walls nothing is left of it
            cage.octetvdb.walls = "OPEN"
        bpy.ops.octetvdb.fit()
        flux, _ = flow_data.load(cage, cage_mesh.read(cage))
        assert np.abs(flux).max() > 1e-4, kind
        cage.octetvdb.divergence_free, cage.octetvdb.walls = True, "CLOSED"
    obj.scale = (0, 0, 0)
    bpy.context.view_layer.update()
    expect_error("scaled to nothing", bpy.ops.octetvdb.fit)
    obj.scale, cage.scale = (1, 1, 1), (1, 2, 1)
    bpy.context.view_layer.update()
    expect_error("apply the scale", bpy.ops.octetvdb.fit)


def check_flow_errors():
    start_over()
    for operator in (bpy.ops.octetvdb.use_guides, bpy.ops.octetvdb.fit, bpy.ops.octetvdb.bake):
        expect_error("make a cage first", operator)
    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.ops.octetvdb.make_cage(shape="BOX", spacing=0.5)
    cage = bpy.context.object
    expect_error("select curve", bpy.ops.octetvdb.use_guides)
    expect_error("no guides", bpy.ops.octetvdb.fit)
    expect_error("no flow yet", bpy.ops.octetvdb.preview)
    cage.octetvdb.path = os.path.join(FOLDER, "never.vdb")
    expect_error("no flow yet", bpy.ops.octetvdb.bake)
    outside = circle("Outside", 3.0, 0, 1.0)
    swirl.select(outside)
    bpy.ops.octetvdb.use_guides()
    expect_error('"Outside"', bpy.ops.octetvdb.fit)
    expect_error("lies outside", bpy.ops.octetvdb.fit)
    point = swirl.guide("Point", [(0, 0, 0), (0, 0, 0)], 1.0)
    swirl.select(point)
    bpy.ops.octetvdb.use_guides()
    expect_error('"Point"', bpy.ops.octetvdb.fit)
    good = circle("Good", 0.5, 0, 1.0)
    swirl.select(good)
    bpy.ops.octetvdb.use_guides()
    for bad in (0.0, float("nan"), "fast"):
        good["speed"] = bad
        expect_error("speed", bpy.ops.octetvdb.fit)
    good["speed"] = 1.0
    bpy.ops.octetvdb.fit()
    # A guide that was deleted is no guide any more.
    bpy.data.objects.remove(good)
    expect_error("no guides", bpy.ops.octetvdb.fit)
