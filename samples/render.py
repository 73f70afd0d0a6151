# SPDX-License-Identifier: Apache-2.0
"""Renders a baked velocity as streamlines in its control cage, with Blender (3.4 or newer) whose
Python has OpenVDB's module, as Debian's has (python3-openvdb):

blender -b --factory-startup --python-exit-code 1 --python samples/render.py -- ASSET VDB PNG

Streamlines start at random voxels, are integrated both ways, and coloured by speed; those in the
quarter of the domain that faces the camera are cut away. Light is painted on the tubes, so that the
picture has no noise.
"""
import json
import math
import sys

import bpy
import numpy as np
import pyopenvdb as vdb
from mathutils import Vector

LINES = 260
STEPS, LENGTH = 300, 4.0  # of a line; its length in units of the domain's half size
LINE_RADIUS, CAGE_RADIUS = 0.010, 0.003  # in the same unit
SIDES = 8  # of a tube
WIDTH, HEIGHT, SAMPLES = 720, 560, 24
CAMERA, LENS = np.array((2.7, -4.0, 2.0)), 66
# Slow to fast, sRGB.
COLOURS = ((0.0, "#27348b"), (0.3, "#1f9fc4"), (0.55, "#8fd6a0"), (0.8, "#f6c65b"), (1.0, "#e8503a"))
BACKGROUND, CAGE_COLOUR = "#0c0f16", "#7d869a"
KEY_LIGHT, AMBIENT = np.array((0.5, -0.2, 0.85)), 0.3


class Velocity:
    """A baked grid as a dense array with trilinear values."""

    def __init__(self, path, name):
        grid = vdb.read(path, name)
        low, high = grid.evalActiveVoxelBoundingBox()
        self.low = np.array(low) - 1
        self.values = np.zeros((*(np.array(high) - self.low + 2), 3))
        grid.copyToArray(self.values, ijk=tuple(int(k) for k in self.low))
        self.voxel = grid.transform.voxelSize()[0]
        self.origin = np.array(grid.transform.indexToWorld(tuple(int(k) for k in self.low)))
        self.speed = np.linalg.norm(self.values, axis=-1)
        inside = np.argwhere(self.speed > 0)
        self.points = self.origin + self.voxel * inside
        self.half = (self.points.max(axis=0) - self.points.min(axis=0)).max() / 2
        self.centre = (self.points.max(axis=0) + self.points.min(axis=0)) / 2

    def __call__(self, x):
        at = np.clip((x - self.origin) / self.voxel, 0, np.array(self.values.shape[:3]) - 1.001)
        cell = at.astype(int)
        t = at - cell
        value = np.zeros_like(x)
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, t, 1 - t), axis=1)
            value += weight[:, None] * self.values[tuple((cell + corner).T)]
        return value


def streamlines(velocity, count):
    """Points (lines, steps, 3) at equal arc length, and speeds (lines, steps)."""
    rng = np.random.default_rng(7)
    start = velocity.points[rng.choice(len(velocity.points), count, replace=False)]
    step = LENGTH * velocity.half / STEPS

    def direction(x):
        v = velocity(x)
        return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)

    halves = []
    for sign in (-1, 1):
        x, points = start, []
        for _ in range(STEPS // 2):
            k1 = direction(x)
            k2 = direction(x + sign * step / 2 * k1)
            x = x + sign * step * k2
            points.append(x)
        halves.append(points)
    lines = np.stack(halves[0][::-1] + [start] + halves[1], axis=1)
    speeds = np.linalg.norm(velocity(lines.reshape(-1, 3)), axis=1).reshape(lines.shape[:2])
    return lines, speeds


def linear(code):
    """An sRGB colour as Blender wants it."""
    srgb = np.array([int(code[k:k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def ramp(values):
    at, colours = [p for p, _ in COLOURS], np.array([linear(code) for _, code in COLOURS])
    return np.stack([np.interp(values, at, colours[:, k]) for k in range(3)], axis=-1)


def lit(points, normals, colours):
    """Lambert's light from one side, darker with distance from the camera."""
    key = KEY_LIGHT / np.linalg.norm(KEY_LIGHT)
    light = AMBIENT + (1 - AMBIENT) * np.clip(normals @ key, 0, 1)
    distance = np.linalg.norm(points - CAMERA, axis=-1) - np.linalg.norm(CAMERA)
    return colours * (light * np.clip(0.9 - 0.45 * distance, 0.25, 1.3))[..., None]


def tubes(lines, radii, colours):
    """One object of tubes around lines (lines, steps, 3), its colours in an attribute."""
    tangents = np.gradient(lines, axis=1)
    tangents /= np.maximum(np.linalg.norm(tangents, axis=-1, keepdims=True), 1e-12)
    normal = np.cross(tangents[:, 0], (0.31, 0.52, 0.79))
    turns = 2 * math.pi * np.arange(SIDES) / SIDES
    points, normals = [], []
    for k in range(lines.shape[1]):
        t = tangents[:, k]
        normal = normal - (normal * t).sum(axis=-1, keepdims=True) * t
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
        side = np.cross(t, normal)
        out = (np.cos(turns)[:, None] * normal[:, None] + np.sin(turns)[:, None] * side[:, None])
        normals.append(out)
        points.append(lines[:, k, None] + radii[:, k, None, None] * out)
    points, normals = np.stack(points, axis=1), np.stack(normals, axis=1)
    colours = lit(points, normals, np.broadcast_to(colours[:, :, None], points.shape))
    number = np.arange(points[..., 0].size).reshape(points.shape[:3])
    beside = np.roll(number, -1, axis=2)
    faces = np.stack([number[:, :-1], beside[:, :-1], beside[:, 1:], number[:, 1:]], axis=-1)
    kept = (radii[:, :-1] > 0) & (radii[:, 1:] > 0)
    mesh = bpy.data.meshes.new("tubes")
    mesh.from_pydata(points.reshape(-1, 3).tolist(), [], faces[kept].reshape(-1, 4).tolist())
    rgba = np.concatenate([colours, np.ones_like(colours[..., :1])], axis=-1)
    mesh.attributes.new("light", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
    thing = bpy.data.objects.new("tubes", mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def glow(thing):
    """A material that shows the colours as they are."""
    material = bpy.data.materials.new("glow")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    attribute, emission = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeEmission")
    output = nodes.new("ShaderNodeOutputMaterial")
    attribute.attribute_name = "light"
    links.new(attribute.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    thing.data.materials.append(material)


def cage_edges(path):
    """End points of the edges of the control mesh's boundary."""
    with open(path) as file:
        asset = json.load(file)
    facets = {}
    for t in asset["tetrahedra"]:
        for k in range(4):
            facet = tuple(sorted(t[:k] + t[k + 1:]))
            facets[facet] = facets.get(facet, 0) + 1
    for o in asset["octahedra"]:
        for a in (o[0], o[5]):
            for b in (o[1], o[3]):
                for c in (o[2], o[4]):
                    facet = tuple(sorted((a, b, c)))
                    facets[facet] = facets.get(facet, 0) + 1
    edges = {pair for f, n in facets.items() if n == 1
             for pair in ((f[0], f[1]), (f[0], f[2]), (f[1], f[2]))}
    x = np.array(asset["vertices"])
    return [x[[a, b]] for a, b in sorted(edges)]


def cut_away(points):
    """The quarter towards the camera."""
    return (points[..., 0] > 0) & (points[..., 1] < 0)


def main(asset, baked, picture):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    velocity = Velocity(baked, "velocity")
    lines, speeds = streamlines(velocity, LINES)
    unit, centre = velocity.half, velocity.centre
    lines = (lines - centre) / unit
    along = np.linspace(0, 1, lines.shape[1])
    radii = LINE_RADIUS * np.minimum(1, 8 * np.minimum(along, 1 - along))
    radii = np.where(cut_away(lines), 0, radii)
    glow(tubes(lines, radii, ramp(speeds / np.quantile(speeds, 0.99))))
    cage = (np.array(cage_edges(asset)) - centre) / unit
    colours = np.broadcast_to(linear(CAGE_COLOUR), cage.shape)
    glow(tubes(cage, np.full(cage.shape[:2], CAGE_RADIUS), colours))

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.lens = LENS
    camera.location = CAMERA
    camera.rotation_euler = (-Vector(CAMERA)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = [*linear(BACKGROUND), 1]

    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.max_bounces = 0
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
