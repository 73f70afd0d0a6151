# SPDX-License-Identifier: Apache-2.0
"""What the checks share: the add-on, installed as users do, scenes and errors."""
import contextlib
import io
import math
import os
import sys

import bpy

ZIP, FOLDER = sys.argv[sys.argv.index("--") + 1:]
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../../../samples/blender"))


def install():
    bpy.ops.preferences.addon_install(filepath=ZIP, overwrite=True)
    bpy.ops.preferences.addon_enable(module="octetvdb_addon")
    assert "octetvdb_addon" in bpy.context.preferences.addons


install()
from octetvdb_addon import cage_mesh, flow_data, library  # noqa: E402
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
