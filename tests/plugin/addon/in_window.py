# SPDX-License-Identifier: Apache-2.0
"""What only a real window shows: the panel, undo, and a bake that does not block and ends on Esc.

Run by addon_test.py under Xvfb with --enable-event-simulate. Arguments after "--": the add-on's zip, a
folder for files, where to put the picture of the panel. Prints "PASSED name" for each check.
"""
import os
import sys
import time
import traceback

import bpy
import mathutils

ZIP, FOLDER, PICTURE = sys.argv[sys.argv.index("--") + 1:]
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../../samples/blender"))
bpy.ops.preferences.addon_install(filepath=ZIP, overwrite=True)
bpy.ops.preferences.addon_enable(module="octetvdb_addon")
bpy.context.preferences.view.show_splash = False
import swirl  # noqa: E402
from octetvdb_addon import library  # noqa: E402

# The sidebar's tab "OctetVDB" in a window of 1280 x 800, from its right edge and top.
TIMEOUT = 120


def window():
    return bpy.context.window_manager.windows[0]


def viewport():
    """Arguments of temp_override for the 3D viewport."""
    area = next(a for a in window().screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    return {"window": window(), "area": area, "region": region}


def wait_until(condition, what):
    """Gives the window its turn until a condition holds."""
    end = time.monotonic() + TIMEOUT
    while not condition():
        assert time.monotonic() < end, f"timeout: {what}"
        yield 0.05


def scene():
    return window().scene


def cage():
    return scene().octetvdb.cage


def volumes():
    return [o.name for o in bpy.data.objects if o.type == "VOLUME"]


def steps():
    with bpy.context.temp_override(**viewport()):
        swirl.make_flow(os.path.join(FOLDER, "window.vdb"))
        bpy.ops.ed.undo_push(message="flow")
    yield 0.2
    yield from undo()
    yield from escape()
    yield from whole_bake()
    yield from picture()


def undo():
    """A cage goes away with one undo and comes back with redo, a preview and a fit likewise."""
    with bpy.context.temp_override(**viewport()):
        bpy.ops.octetvdb.preview("EXEC_DEFAULT", True)
        before = {o.name for o in bpy.data.objects}
        body = bpy.data.objects["Vase"]
        body.hide_set(False)
        swirl.select(body)
        bpy.ops.ed.undo_push(message="select")
        bpy.ops.octetvdb.make_cage("EXEC_DEFAULT", True, shape="BOX", spacing=0.5)
    yield 0.2
    after = {o.name for o in bpy.data.objects}
    assert len(after - before) == 1, after - before
    name = cage().name
    assert name in after - before
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.undo()
    yield 0.2
    assert {o.name for o in bpy.data.objects} == before
    assert cage().name == "Vase Cage", cage()
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.redo()
    yield 0.2
    assert cage().name == name
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.undo()
    yield 0.2
    from octetvdb_addon import flow_data
    assert flow_data.exists(cage())
    print("PASSED undo")


def start_bake(resolution, path):
    cage().octetvdb.resolution = resolution
    cage().octetvdb.path = path
    with bpy.context.temp_override(**viewport()):
        result = bpy.ops.octetvdb.bake("INVOKE_DEFAULT", True)
    assert result == {"RUNNING_MODAL"}, result


def escape():
    """While it bakes, the window has its turn and shows progress; Esc ends it and leaves nothing."""
    path = os.path.join(FOLDER, "escaped.vdb")
    start_bake(128, path)
    assert scene().octetvdb.task
    assert not bpy.ops.octetvdb.bake.poll(), "a second bake may start"
    turns, seen = 0, set()
    end = time.monotonic() + TIMEOUT
    while len(seen) < 3 and time.monotonic() < end:
        assert scene().octetvdb.task, "the bake ended too early to see it"
        seen.add((scene().octetvdb.task, scene().octetvdb.progress))
        turns += 1
        yield 0.05
    assert len(seen) >= 3 and turns >= 3, (turns, seen)
    asked = time.monotonic()
    area = viewport()["area"]
    window().event_simulate(type="ESC", value="PRESS", x=area.x + 200, y=area.y + 200)
    window().event_simulate(type="ESC", value="RELEASE", x=area.x + 200, y=area.y + 200)
    yield from wait_until(lambda: not scene().octetvdb.task, "Esc")
    print(f"MEASURED Esc to end {time.monotonic() - asked:.2f} s, {turns} turns of the window before")
    assert not os.path.exists(path) and os.listdir(FOLDER) == ["window.vdb"], os.listdir(FOLDER)
    assert len(volumes()) == 1
    print("PASSED escape")


def whole_bake():
    """A modal bake that is left alone ends with its volume, and undo takes the volume back."""
    bpy.data.objects.remove(bpy.data.objects[volumes()[0]])
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.undo_push(message="no volume")
    path = os.path.join(FOLDER, "whole.vdb")
    start_bake(40, path)
    yield from wait_until(lambda: not scene().octetvdb.task, "bake")
    yield 0.2
    assert os.path.exists(path) and len(volumes()) == 1
    assert "voxels" in cage().octetvdb.certificate
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.undo()
    yield 0.2
    assert not volumes(), volumes()
    with bpy.context.temp_override(**viewport()):
        bpy.ops.ed.redo()
    yield 0.2
    assert len(volumes()) == 1
    print("PASSED whole_bake")


def picture():
    """The panel as artists see it."""
    area = viewport()["area"]
    space = area.spaces.active
    space.show_region_ui = True
    bpy.context.preferences.view.ui_scale = 0.72  # all four panels in one picture
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    space.overlay.show_extras = False
    space.shading.type, space.shading.color_type = "SOLID", "OBJECT"
    bpy.data.objects["Vase"].hide_set(True)
    for name in volumes():
        bpy.data.objects[name].hide_set(True)
    for child in cage().children:
        if child.name.endswith("Streamlines"):
            child.color, child.show_in_front = (1.0, 0.5, 0.1, 1), True
    cage().color = (0.1, 0.1, 0.1, 1)
    with bpy.context.temp_override(**viewport()):
        space.region_3d.view_rotation = mathutils.Euler((1.2, 0, 0.7)).to_quaternion()
        swirl.select(cage())
        bpy.ops.view3d.view_selected()
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.view_layer.objects.active = cage()
    yield 0.5
    cage().octetvdb.path = "//flow.vdb"
    yield from show_tab(area)
    with bpy.context.temp_override(window=window()):
        bpy.ops.screen.screenshot(filepath=PICTURE)
    assert os.path.getsize(PICTURE) > 10000
    print("PASSED picture")


def show_tab(area):
    """Clicks the sidebar's tab "OctetVDB", the lowest one."""
    sidebar = next(r for r in area.regions if r.type == "UI")
    if hasattr(sidebar, "active_panel_category") and not bpy.types.Region.bl_rna.properties[
            "active_panel_category"].is_readonly:
        sidebar.active_panel_category = "OctetVDB"
        yield 0.5
        return
    x = sidebar.x + sidebar.width - 10
    for below_top in (117, 135, 153, 171):
        y = sidebar.y + sidebar.height - below_top
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
        yield 0.2
        window().event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
        window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=x, y=y)
        yield 0.5


def run(generator):
    def tick():
        try:
            return next(generator)
        except StopIteration:
            print("DONE")
        except BaseException:  # noqa: B902 - told to the outer test
            traceback.print_exc()
            print("FAILED")
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
    return tick


bpy.app.timers.register(run(steps()), first_interval=0.5)
