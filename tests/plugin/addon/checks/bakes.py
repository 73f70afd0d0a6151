# SPDX-License-Identifier: Apache-2.0
"""Volumes that the bake makes, and the job that makes them."""
import os
import resource
import signal
import time

import bpy
import numpy as np
import pyopenvdb

from .common import FOLDER, octetvdb, swirl, start_over, expect_error, box_with_flow, field_of
from octetvdb_addon import bake, cage_mesh, flow_data


# Blender keeps 32-bit floats.
TOLERANCE_OF_VALUES = 1e-5


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
