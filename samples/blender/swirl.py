#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A vase filled with a cage, two guide curves, and the incompressible flow that follows them: made,
baked and rendered by the add-on's operators.

Usage: blender -b --factory-startup --python swirl.py -- PICTURE.png [BAKED.vdb]
The add-on has to be installed (see README.md).
"""
import math
import os
import sys
import tempfile

import bpy
import mathutils


def vase():
    """A closed surface of revolution, bulging below and above."""
    rings, segments = 24, 32
    vertices, faces = [(0, 0, -1.5)], []
    for ring in range(1, rings):
        angle = math.pi * ring / rings
        radius = math.sin(angle) * (1 + 0.25 * math.cos(4 * angle))
        z = -1.5 * math.cos(angle)
        vertices += [(radius * math.cos(2 * math.pi * k / segments),
                      radius * math.sin(2 * math.pi * k / segments), z) for k in range(segments)]
    vertices.append((0, 0, 1.5))
    for k in range(segments):
        following = (k + 1) % segments
        faces.append((0, 1 + following, 1 + k))
        for ring in range(rings - 2):
            a = 1 + ring * segments
            faces.append((a + k, a + following, a + segments + following, a + segments + k))
        last = 1 + (rings - 2) * segments
        faces.append((last + k, last + following, len(vertices) - 1))
    mesh = bpy.data.meshes.new("Vase")
    mesh.from_pydata(vertices, [], faces)
    return link(bpy.data.objects.new("Vase", mesh))


def guide(name, points, speed, cyclic=False):
    """A smooth curve through points."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(len(points) - 1)
    for handle, point in zip(spline.bezier_points, points):
        handle.co = point
        handle.handle_left_type = handle.handle_right_type = "AUTO"
    spline.use_cyclic_u = cyclic
    obj = link(bpy.data.objects.new(name, curve))
    obj["speed"] = speed
    return obj


def link(obj):
    bpy.context.collection.objects.link(obj)
    return obj


def select(*objects):
    bpy.ops.object.select_all(action="DESELECT")
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def guides():
    """A ring around the belly, and a spiral up through the middle."""
    ring = [(0.85 * math.cos(a), 0.85 * math.sin(a), 0)
            for a in (2 * math.pi * k / 8 for k in range(8))]
    spiral = [(0.35 * math.cos(a), 0.35 * math.sin(a), 0.2 * k - 0.7)
              for k, a in enumerate(math.pi / 2 * k for k in range(8))]
    return guide("Ring", ring, 1.5, cyclic=True), guide("Spiral", spiral, 1.0)


def make_flow(path):
    """Cage, fit, preview and bake; returns the cage."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    body = vase()
    select(body)
    bpy.ops.octetvdb.make_cage(shape="FILL", spacing=0.34)
    cage = bpy.context.object
    body.hide_set(True)
    body.hide_render = True
    curves = guides()
    select(*curves)
    bpy.ops.octetvdb.use_guides()
    bpy.ops.octetvdb.fit()
    cage.octetvdb.streamline_count = 90
    bpy.ops.octetvdb.preview()
    cage.octetvdb.path = path
    cage.octetvdb.resolution = 48
    bpy.ops.octetvdb.bake()
    return cage


def emission(name, colour, strength):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (*colour, 1)
    shader.inputs["Strength"].default_value = strength
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def smoke():
    """Smoke that glows where the baked velocity is high: the renderer reads the grid itself."""
    material = bpy.data.materials.new("Smoke")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    velocity = nodes.new("ShaderNodeAttribute")
    velocity.attribute_name = "velocity"
    speed = nodes.new("ShaderNodeVectorMath")
    speed.operation = "LENGTH"
    ramp = nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.3, 0.9
    ramp.color_ramp.elements[0].color = (0.02, 0.05, 0.2, 1)
    ramp.color_ramp.elements[1].color = (1.0, 0.35, 0.05, 1)
    volume = nodes.new("ShaderNodeVolumePrincipled")
    volume.inputs["Density"].default_value = 0.5
    strength = nodes.new("ShaderNodeMath")
    strength.operation = "MULTIPLY"
    strength.inputs[1].default_value = 0.45
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(velocity.outputs["Vector"], speed.inputs[0])
    links.new(speed.outputs["Value"], ramp.inputs["Fac"])
    links.new(speed.outputs["Value"], strength.inputs[0])
    links.new(strength.outputs[0], volume.inputs["Emission Strength"])
    links.new(ramp.outputs["Color"], volume.inputs["Emission Color"])
    links.new(volume.outputs["Volume"], output.inputs["Volume"])
    return material


def dress(cage):
    """Materials, light and camera."""
    for child in cage.children:
        if child.type == "VOLUME":
            child.data.materials.append(smoke())
        elif child.name.endswith("Streamlines"):
            child.data.materials.append(emission("Streak", (0.6, 0.8, 1.0), 1.5))
        else:
            child.hide_render = True
    for obj in bpy.data.objects:
        if obj.type == "CURVE" and obj.parent is None:
            obj.hide_render = True
    world = bpy.data.worlds.new("Dark")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.01, 0.01, 0.015, 1)
    bpy.context.scene.world = world
    sun = link(bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN")))
    sun.data.energy = 2
    sun.rotation_euler = (0.7, 0.3, 0)
    camera = link(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    camera.location = (5.4, -4.6, 1.8)
    camera.rotation_euler = (-mathutils.Vector(camera.location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = camera


def render(path, width=480, height=270, samples=32):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.seed = 0
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def main(picture, baked=None):
    with tempfile.TemporaryDirectory() as folder:
        cage = make_flow(baked or os.path.join(folder, "swirl.vdb"))
        print(cage.octetvdb.flow_note)
        print(cage.octetvdb.certificate)
        dress(cage)
        render(os.path.abspath(picture))


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
