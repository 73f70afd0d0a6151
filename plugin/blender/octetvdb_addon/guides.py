# SPDX-License-Identifier: Apache-2.0
"""Guide curves: Blender's curve objects as polylines with speeds, in a cage's space."""
import numpy as np

from .problems import Problem

SPEED = "speed"


def polylines(context, obj):
    """The splines of a curve object as polylines (n, 3) in world space, in their own direction; a
    closed one ends where it starts."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    if _has_width(obj.data):
        # As drawn it would be a tube. Its own points, without the modifiers.
        evaluated = obj.copy()
        evaluated.data = obj.data.copy()
        evaluated.data.bevel_depth = evaluated.data.extrude = 0
        evaluated.data.bevel_object = None
    try:
        mesh = evaluated.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        edges = {tuple(sorted(edge.vertices)) for edge in mesh.edges}
        evaluated.to_mesh_clear()
    finally:
        if _has_width(obj.data):
            _remove(evaluated)
    to_world = np.array(obj.matrix_world)
    points = points.reshape(-1, 3) @ to_world[:3, :3].T + to_world[:3, 3]
    starts = [k for k in range(len(points)) if (k - 1, k) not in edges] + [len(points)]
    lines = []
    for first, end in zip(starts, starts[1:]):
        line = points[first:end]
        if (first, end - 1) in edges and end - first > 2:
            line = np.vstack([line, line[:1]])
        lines.append(line)
    return [line for line in lines if len(line) > 1]


def in_cage(context, cage, obj):
    """Points and speeds, one each, of a guide object's splines, in the cage's space."""
    speed = obj.get(SPEED, 1.0)
    if not isinstance(speed, (int, float)) or not np.isfinite(speed) or speed == 0:
        raise Problem(f'the speed of guide "{obj.name}" is no number, or 0')
    to_cage = np.linalg.inv(np.array(cage.matrix_world))
    found = []
    for line in polylines(context, obj):
        if speed < 0:
            line = line[::-1]
        local = line @ to_cage[:3, :3].T + to_cage[:3, 3]
        # A length of the cage's space to one of the world, along each piece, then at each point.
        world = np.linalg.norm(np.diff(line, axis=0), axis=1)
        ratio = np.linalg.norm(np.diff(local, axis=0), axis=1) / np.where(world > 0, world, 1)
        at_points = (np.append(ratio, ratio[-1]) + np.insert(ratio, 0, ratio[0])) / 2
        found.append((local, abs(speed) * at_points))
    if not found:
        raise Problem(f'guide "{obj.name}" has no spline with two points')
    return found


def objects(cage):
    """The guide objects of a cage that still exist."""
    return [entry.object for entry in cage.octetvdb.guides
            if entry.object is not None and entry.object.users_scene]


def library_guides(context, cage):
    """What the library's fit takes: (name, points, speeds) for each spline."""
    found = []
    for obj in objects(cage):
        splines = in_cage(context, cage, obj)
        for k, (points, speeds) in enumerate(splines):
            name = obj.name if len(splines) == 1 else f"{obj.name}, spline {k + 1}"
            found.append((name, points, speeds))
    return found


def _has_width(curve):
    return bool(curve.bevel_depth or curve.extrude or curve.bevel_object)


def _remove(obj):
    import bpy
    data = obj.data
    bpy.data.objects.remove(obj)
    bpy.data.curves.remove(data)
