# SPDX-License-Identifier: Apache-2.0
"""Smooth velocity fields that are exactly incompressible (or exactly curl-free), authored on a
coarse cage of tetrahedra and octahedra and baked to OpenVDB at any resolution.

    import octetvdb

    asset = octetvdb.ControlAsset.read("box.octet.json")
    octetvdb.bake(asset, "box.vdb", resolution=128, target="blender")

    form = asset.form("velocity")
    refiner = octetvdb.Refiner(asset.mesh, levels=3)
    field = refiner.field(form.degree, form.coefficients())
    values, inside = field.sample(points)

Lengths are world units of the asset, indices count from 0, and a simplex's orientation is the order
of its vertices. Arrays that are called views are read-only, share the library's memory and keep it
alive. Long calls release the GIL; they can be cancelled from their `progress` callback and by
Ctrl-C. Errors are octetvdb.InputError, IoError, MemoryError and Cancelled, with `file`, `place` and
`reason`.
"""
from ._octetvdb import (BakedFile, BakeReport, CageQuality, Cancelled, Certificate, Complex,
                        ControlAsset, ControlMesh, CurlNoise, Error, Field, Fit, FitReport,
                        FitResult, Form, GridInfo, GuideConflict, GuideCurve, GuideReport,
                        GuideVector, InputError, IoError, MemoryError, PointSource, Refiner,
                        RigidRotation, SampledFrame, ThreadLimit, UniformFlow, VerifiedGrid, VortexLine,
                        VortexRing, __version__, bake, box_cage, cage_quality, fill_surface,
                        fill_tetrahedra, integrate, merge, nearest_closed, read_grid_info,
                        sample_velocity, spaced_points, streamlines, targets, verify)
from ._meshio import from_meshio, to_meshio
from ._preview import preview

__all__ = ["BakedFile", "BakeReport", "CageQuality", "Cancelled", "Certificate", "Complex",
           "ControlAsset", "ControlMesh", "CurlNoise", "Error", "Field", "Fit", "FitReport",
           "FitResult", "Form", "GridInfo", "GuideConflict", "GuideCurve", "GuideReport",
           "GuideVector", "InputError", "IoError", "MemoryError", "PointSource", "Refiner",
           "RigidRotation", "SampledFrame", "ThreadLimit", "UniformFlow", "VerifiedGrid", "VortexLine",
           "VortexRing", "__version__", "bake", "box_cage", "cage_quality", "fill_surface",
           "fill_tetrahedra", "from_meshio", "integrate", "merge", "nearest_closed", "preview",
           "read_grid_info", "sample_velocity", "spaced_points", "streamlines", "targets",
           "to_meshio", "verify"]
