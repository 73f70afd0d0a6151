# SPDX-License-Identifier: Apache-2.0
"""Checks of the add-on, run inside the real Blender, headless, by addon_test.py.

Arguments after "--": the add-on's zip, a folder for files. Prints "PASSED name" for each check.
"""
import contextlib
import io
import math
import os
import resource
import signal
import sys
import time
import traceback

import bpy
import numpy as np
import pyopenvdb

ZIP, FOLDER = sys.argv[sys.argv.index("--") + 1:]
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../../samples/blender"))


def install():
    bpy.ops.preferences.addon_install(filepath=ZIP, overwrite=True)
    bpy.ops.preferences.addon_enable(module="octetvdb_addon")
    assert "octetvdb_addon" in bpy.context.preferences.addons


install()
import octetvdb_addon  # noqa: E402
from octetvdb_addon import bake, cage_mesh, flow_data, library, volume  # noqa: E402
import swirl  # noqa: E402

octetvdb = library.octetvdb


def start_over():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_enable(module="octetvdb_addon")


def expect_error(reason, operator, *arguments, **options):
    """The operator reports an error that has the reason, and prints no traceback."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
        try:
            result = operator(*arguments, **options)
        except RuntimeError as error:  # how Blender hands reports to scripts
            message = str(error)
        else:
            raise AssertionError(f"{operator.idname()} gave {result}, not an error: {reason}")
    assert reason.lower() in message.lower(), f"{message!r} does not say {reason!r}"
    assert "internal error" not in message.lower(), message
    assert "Traceback" not in told.getvalue() + message, told.getvalue()


def sphere(radius=1.0, name="Ball"):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=radius)
    bpy.context.object.name = name
    return bpy.context.object


def circle(name, radius, z, speed):
    points = [(radius * math.cos(a), radius * math.sin(a), z)
              for a in (2 * math.pi * k / 8 for k in range(8))]
    return swirl.guide(name, points, speed, cyclic=True)


def box_with_flow(path="box.vdb"):
    """A box cage with a flow around two rings, ready to bake."""
    start_over()
    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.ops.octetvdb.make_cage(shape="BOX", spacing=0.5)
    cage = bpy.context.object
    swirl.select(circle("Low", 0.5, -0.4, 1.0), circle("High", 0.5, 0.4, -1.0))
    bpy.ops.octetvdb.use_guides()
    bpy.ops.octetvdb.fit()
    cage.octetvdb.path = os.path.join(FOLDER, path)
    cage.octetvdb.resolution = 32
    return cage


def field_of(cage, levels=2):
    control = cage_mesh.read(cage)
    flux, boundary = flow_data.load(cage, control)
    return octetvdb.Refiner(control, levels).field(2, flux, boundary)


def guide_points(cage, name):
    from octetvdb_addon import guides
    (points, speeds), = guides.in_cage(bpy.context, cage, bpy.data.objects[name])
    return points, speeds


# ---- cages -------------------------------------------------------------------------------------

def check_module_is_the_bundled_one():
    assert octetvdb.__name__ == "octetvdb_addon.octetvdb", octetvdb.__name__
    manifest = os.path.join(os.path.dirname(octetvdb_addon.__file__), "blender_manifest.toml")
    import tomllib
    with open(manifest, "rb") as file:
        manifest = tomllib.load(file)
    assert manifest["version"] == ".".join(map(str, octetvdb_addon.bl_info["version"]))
    assert manifest["version"] == octetvdb.__version__


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
        assert "without Gmsh" in str(e), e
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


# ---- flow --------------------------------------------------------------------------------------

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


# ---- preview -----------------------------------------------------------------------------------

def check_preview_draws_the_flow():
    cage = box_with_flow()
    cage.octetvdb.arrow_count, cage.octetvdb.streamline_count = 150, 30
    bpy.ops.octetvdb.preview()
    found = {child["octetvdb_preview"]: child for child in cage.children}
    assert set(found) == {"Arrows", "Streamlines"}
    field = field_of(cage, cage.octetvdb.preview_levels)
    arrows = found["Arrows"].data.splines
    assert 100 <= len(arrows) <= 150, len(arrows)
    for spline in list(arrows)[::10]:
        tail, tip = (np.array(spline.points[k].co[:3]) for k in (0, 1))
        (value,), (inside,) = field.sample([(tail + tip) / 2])
        cosine = value @ (tip - tail) / np.linalg.norm(value) / np.linalg.norm(tip - tail)
        assert inside and cosine > 0.9999, cosine
    lines = found["Streamlines"].data.splines
    assert 5 <= len(lines) <= 30, len(lines)
    for spline in lines:
        points = np.array([p.co[:3] for p in spline.points])
        steps = np.diff(points, axis=0)
        values, inside = field.sample((points[1:] + points[:-1]) / 2)
        assert inside.all()
        cosine = np.einsum("ij,ij->i", values, steps) / np.linalg.norm(values, axis=1) / \
            np.linalg.norm(steps, axis=1)
        assert np.median(cosine) > 0.99, np.median(cosine)
    # A second preview replaces the first, and keeps its materials.
    material = bpy.data.materials.new("Mine")
    found["Arrows"].data.materials.append(material)
    count = len(bpy.data.objects), len(bpy.data.curves)
    cage.octetvdb.arrow_count = 50
    bpy.ops.octetvdb.preview()
    assert (len(bpy.data.objects), len(bpy.data.curves)) == count
    assert len(found["Arrows"].data.splines) <= 50
    assert found["Arrows"].data.materials[0] == material


def check_preview_of_two_thousand_cells():
    """Times it, for people to read: speed is not asserted."""
    start_over()
    sphere(1.0)
    bpy.ops.octetvdb.make_cage(shape="FILL", spacing=0.2)
    cage = bpy.context.object
    swirl.select(circle("Low", 0.5, -0.4, 1.0), circle("High", 0.5, 0.4, -1.0))
    bpy.ops.octetvdb.use_guides()
    before = time.perf_counter()
    bpy.ops.octetvdb.fit()
    fitted = time.perf_counter()
    bpy.ops.octetvdb.preview()
    print(f"MEASURED {cage_mesh.read(cage).complex.cell_count} cells: fit "
          f"{fitted - before:.2f} s, preview {time.perf_counter() - fitted:.2f} s")


# ---- bake --------------------------------------------------------------------------------------

def grid_samples(path, name="velocity"):
    """Where Blender draws active voxels (centred at ijk + 1/2), and their values."""
    grid = pyopenvdb.read(path, name)
    points, values = [], []
    for item in grid.iterOnValues():
        points.append(grid.transform.indexToWorld(tuple(c + 0.5 for c in item.min)))
        values.append(item.value)
    return np.array(points), np.array(values)


def bounds_in_blender(obj, grid="density"):
    """Box of the density as Blender makes a mesh of it, in world space."""
    measured = swirl.link(bpy.data.objects.new("Measured", bpy.data.meshes.new("Measured")))
    modifier = measured.modifiers.new("surface", "VOLUME_TO_MESH")
    modifier.object, modifier.grid_name = obj, grid
    modifier.threshold, modifier.resolution_mode = 0.5, "GRID"
    evaluated = measured.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.array([evaluated.matrix_world @ v.co for v in evaluated.data.vertices])
    bpy.data.objects.remove(measured)
    return points.min(axis=0), points.max(axis=0)


def check_bake_is_the_library_s_flow():
    cage = box_with_flow()
    path = cage.octetvdb.path
    bpy.ops.octetvdb.bake()
    obj = next(child for child in cage.children if child.type == "VOLUME")
    data = obj.data
    assert data.filepath == path and data.grids.error_message == ""
    assert data.grids.load()
    assert {g.name: g.data_type for g in data.grids} == {"velocity": "VECTOR_FLOAT",
                                                         "density": "FLOAT"}
    assert data.velocity_grid == "velocity" and data.velocity_unit == "SECOND"
    # Values where Blender draws them are the field's there.
    info = {g.name: g for g in octetvdb.read_grid_info(path)}["velocity"]
    field = field_of(cage, levels=int(info.metadata["octet_levels"]))
    points, values = grid_samples(path)
    expected, inside = field.sample(points)
    # Points on the walls may fall to either side in the last digit.
    deep = inside & (np.abs(points) < 1 - 1e-6).all(axis=1)
    assert deep.sum() > 0.8 * len(points)
    error = np.linalg.norm(values - expected, axis=1)
    error /= np.linalg.norm(expected, axis=1).max()
    # Samples along the walls; inside, means near them that leave no divergence.
    size = info.voxel_size
    at_wall = deep & (np.abs(points) > 1 - 1.5 * size).any(axis=1)
    assert at_wall.sum() > 0.1 * len(points)
    assert error[at_wall].max() < TOLERANCE_OF_VALUES, error[at_wall].max()
    assert np.sqrt(np.mean(error[deep]**2)) < 0.02, np.sqrt(np.mean(error[deep]**2))
    # The volume lies where the cage is, also when the cage moves.
    for move in ((0, 0, 0), (4, -2, 1)):
        cage.location = move
        bpy.context.view_layer.update()
        low, high = bounds_in_blender(obj)
        assert np.abs(low - (np.array(move) - 1)).max() < size, low
        assert np.abs(high - (np.array(move) + 1)).max() < size, high
        assert np.abs((low + high) / 2 - move).max() < 0.02 * size, (low + high) / 2
    # The certificate is what anyone measures in the file.
    measured = octetvdb.verify(path, "velocity")[0].certificate
    told = cage.octetvdb.certificate
    assert f"{measured.active_voxels:,} voxels" in told and \
        f"Divergence max {measured.max_divergence:.1e}" in told, told
    assert measured.max_divergence < 0.1, told
    # Nothing passes the walls, on which the outermost voxels lie.
    assert measured.throughflow < 1e-6 * measured.max_speed, told
    # A second bake replaces the first one's volume.
    count = len(bpy.data.objects), len(bpy.data.volumes)
    bpy.ops.octetvdb.bake()
    assert (len(bpy.data.objects), len(bpy.data.volumes)) == count
    # For the outer test: the command line and Python bake the same.
    control = cage_mesh.read(cage)
    flux, _ = flow_data.load(cage, control)
    asset = flow_data.make_asset(control, flow_data.about(bpy.context, cage), flux)
    asset.write(os.path.join(FOLDER, "same.octet.json"))


# Collocated bakes may spread a voxel's velocity to cancel its divergence; see the bake's options.
TOLERANCE_OF_VALUES = 1e-5


def check_baked_from_an_opened_asset():
    """A cage and its flow survive being written as a control asset and opened again."""
    cage = box_with_flow()
    control = cage_mesh.read(cage)
    flux, _ = flow_data.load(cage, control)
    asset = flow_data.make_asset(control, flow_data.about(bpy.context, cage), flux)
    path = os.path.join(FOLDER, "opened.octet.json")
    asset.write(path)
    start_over()
    bpy.ops.octetvdb.open_asset(filepath=path)
    opened = bpy.context.object
    again = cage_mesh.read(opened)
    assert np.array_equal(again.vertices, control.vertices)
    assert np.array_equal(again.creases, control.creases)
    assert np.array_equal(flow_data.load(opened, again)[0], flux)


def check_particles_stay_in_the_cage():
    """Advection through the baked grid, as a script in Blender would do it."""
    cage = box_with_flow("particles.vdb")
    bpy.ops.octetvdb.bake()
    grid = pyopenvdb.read(cage.octetvdb.path, "velocity")
    low, high = grid.evalActiveVoxelBoundingBox()
    shape = np.array(high) - low + 1
    values = np.zeros((*shape, 3), np.float32)
    grid.copyToArray(values, ijk=low)
    size = grid.transform.voxelSize()[0]
    origin = np.array(grid.transform.indexToWorld(tuple(c + 0.5 for c in low)))

    def velocity(points):
        """Trilinear, as Blender and solvers do."""
        at = np.clip((points - origin) / size, 0, shape - 1.000001)
        base = at.astype(int)
        f = at - base
        total = np.zeros_like(points)
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, f, 1 - f), axis=1)
            total += weight[:, None] * values[tuple((base + corner).T)]
        return total

    rng = np.random.default_rng(3)
    points = rng.uniform(-0.95, 0.95, (500, 3))
    start = points.copy()
    step = 0.5 * size / np.linalg.norm(values, axis=-1).max()
    for _ in range(600):
        middle = points + step / 2 * velocity(points)
        points = points + step * velocity(middle)
    assert (np.abs(points) <= 1 + 1e-6).all(), np.abs(points).max()
    moved = np.linalg.norm(points - start, axis=1)
    assert np.median(moved) > 0.05, np.median(moved)


def check_animated_bake():
    cage = box_with_flow("moving.vdb")
    low = bpy.data.objects["Low"]
    low.keyframe_insert("location", frame=1)
    low.location.z += 0.3
    low.keyframe_insert("location", frame=5)
    settings = cage.octetvdb
    settings.use_frames, settings.frame_first, settings.frame_last = True, 2, 4
    settings.resolution = 16
    bpy.context.scene.frame_set(1)
    bpy.ops.octetvdb.bake()
    assert bpy.context.scene.frame_current == 1
    files = [os.path.join(FOLDER, f"moving.{k:04d}.vdb") for k in (2, 3, 4)]
    assert all(map(os.path.exists, files))
    data = next(child for child in cage.children if child.type == "VOLUME").data
    assert data.is_sequence and data.frame_duration == 3 and data.frame_start == 2
    for frame in (2, 3, 4):
        bpy.context.scene.frame_set(frame)
        data.grids.load()
        assert data.grids.frame_filepath == files[frame - 2], data.grids.frame_filepath
    means = [grid_samples(path)[1] for path in files]
    assert np.abs(means[0] - means[1]).max() > 1e-3
    settings.frame_first, settings.frame_last = 4, 2
    expect_error("last frame", bpy.ops.octetvdb.bake)


def check_bake_errors():
    cage = box_with_flow("errors.vdb")
    settings = cage.octetvdb
    before = sorted(os.listdir(FOLDER))
    volumes = len(bpy.data.volumes)
    settings.path = os.path.join(FOLDER, "no", "such", "folder.vdb")
    expect_error("cannot be written", bpy.ops.octetvdb.bake)
    settings.path = "/proc/flow.vdb"  # where not even root can write
    expect_error("cannot be written", bpy.ops.octetvdb.bake)
    settings.path = "//beside.vdb"
    expect_error("save the .blend", bpy.ops.octetvdb.bake)
    settings.path = ""
    expect_error("name the file", bpy.ops.octetvdb.bake)
    settings.path = os.path.join(FOLDER, "full.vdb")
    settings.size_mode, settings.voxel_size = "VOXEL", 1e-6
    expect_error("levels", bpy.ops.octetvdb.bake)
    settings.size_mode = "RESOLUTION"
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))  # as a disk that is full
    try:
        expect_error("cannot be written", bpy.ops.octetvdb.bake)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert sorted(os.listdir(FOLDER)) == before, "a failed bake left files"
    assert len(bpy.data.volumes) == volumes
    assert bpy.context.scene.octetvdb.task == ""


def check_the_job_can_be_cancelled():
    cage = box_with_flow("cancelled.vdb")
    cage.octetvdb.resolution = 64
    job, _ = bake.prepare(bpy.context, cage)
    seen = []
    progress = job.progress

    def stop_at_second(*report):
        seen.append(report)
        if len(seen) == 2:
            job.cancel()
        return progress(*report)
    job.progress = stop_at_second
    job.start()
    while job.running():
        time.sleep(0.01)
    assert isinstance(job.error, octetvdb.Cancelled), job.error
    assert len(seen) == 2 and not os.path.exists(cage.octetvdb.path)


def check_files_survive_saving():
    """Cage, flow and settings are in the .blend; a path beside it is found."""
    cage = box_with_flow()
    flux, _ = flow_data.load(cage, cage_mesh.read(cage))
    cage.octetvdb.path = "//beside.vdb"
    blend = os.path.join(FOLDER, "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    start_over()
    bpy.ops.wm.open_mainfile(filepath=blend)
    cage = bpy.context.scene.octetvdb.cage
    assert np.array_equal(flow_data.load(cage, cage_mesh.read(cage))[0], flux)
    assert volume.absolute(cage.octetvdb.path) == os.path.join(FOLDER, "beside.vdb")
    bpy.ops.octetvdb.bake()
    assert os.path.exists(os.path.join(FOLDER, "beside.vdb"))


def check_it_can_be_disabled_and_enabled():
    bpy.ops.preferences.addon_disable(module="octetvdb_addon")
    assert not hasattr(bpy.types.Scene, "octetvdb")
    bpy.ops.preferences.addon_enable(module="octetvdb_addon")
    assert hasattr(bpy.types.Scene, "octetvdb")


def main():
    failed = []
    only = os.environ.get("ONLY", "")
    for name, check in list(globals().items()):
        if not name.startswith("check_") or only not in name:
            continue
        before = time.perf_counter()
        try:
            check()
            print(f"PASSED {name[6:]} {time.perf_counter() - before:.1f} s")
        except Exception:  # noqa: B902 - the other checks still run
            failed.append(name)
            print(f"FAILED {name[6:]}\n{traceback.format_exc()}")
        sys.stdout.flush()
    sys.exit(1 if failed else 0)


main()
