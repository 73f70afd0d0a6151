# SPDX-License-Identifier: Apache-2.0
"""Streamlines that the preview draws."""
import time

import bpy
import numpy as np

from .common import swirl, start_over, sphere, circle, box_with_flow, field_of
from octetvdb_addon import cage_mesh


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
