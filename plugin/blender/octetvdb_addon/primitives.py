# SPDX-License-Identifier: Apache-2.0
"""Primitive flows: Blender's empties as the library's primitives, in a cage's space."""
import numpy as np

from . import library
from .problems import Problem

# Scales that differ by more than this make a primitive none of its kind any more.
_UNIFORM = 1e-4
# Curl noise has details from the empty's size down to this share of it.
_FINEST_NOISE = 0.25


def objects(cage):
    """The primitive objects of a cage that still exist."""
    return [entry.object for entry in cage.octetvdb.primitives
            if entry.object is not None and entry.object.users_scene
            and entry.object.octetvdb.primitive != "NONE"]


def in_cage(cage, obj):
    """The library's primitive for an empty. Lengths are the world's, turned into the cage's."""
    octetvdb = library.need()
    to_cage = np.linalg.inv(np.array(cage.matrix_world))
    scale = _uniform_scale(cage, to_cage)
    place = np.array(obj.matrix_world)
    centre = to_cage[:3, :3] @ place[:3, 3] + to_cage[:3, 3]
    axis = to_cage[:3, :3] @ place[:3, 2]
    length = np.linalg.norm(axis)
    if not length > 0:
        raise Problem(f'"{obj.name}" is scaled to nothing')
    axis /= length
    size = np.linalg.norm(place[:3, :2], axis=0).mean() * scale
    settings = obj.octetvdb
    strength, core = settings.strength, settings.core * scale
    kind = settings.primitive
    if kind == "UNIFORM":
        return octetvdb.UniformFlow(strength * scale * axis)
    if kind == "ROTATION":
        return octetvdb.RigidRotation(centre, strength * axis)
    if kind == "VORTEX":
        return octetvdb.VortexLine(centre, axis, strength * scale**2, core)
    if kind == "RING":
        return octetvdb.VortexRing(centre, axis, size, strength * scale**2, core)
    if kind == "SOURCE":
        return octetvdb.PointSource(centre, strength * scale**3, core)
    return octetvdb.CurlNoise(strength * scale, size, _FINEST_NOISE * size, seed=settings.seed)


def flux(control, primitives, closed_facets, divergence_free):
    """Fluxes of some primitives together, without flux through closed facets. Needs nothing of
    Blender's."""
    octetvdb = library.need()
    total = sum(octetvdb.integrate(primitive, control) for primitive in primitives)
    if divergence_free:
        return octetvdb.nearest_closed(control, 2, total, closed_facets)
    total[closed_facets] = 0
    return total


def _uniform_scale(cage, to_cage):
    scales = np.linalg.norm(to_cage[:3, :3], axis=0)
    if np.ptp(scales) > _UNIFORM * scales.max():
        raise Problem(f'Apply the scale of "{cage.name}": with primitives it has to be the same along '
                      "all axes")
    return scales.mean()
