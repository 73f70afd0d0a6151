# SPDX-License-Identifier: Apache-2.0
"""The flow of a cage: fluxes through its facets, kept as custom properties of the cage's mesh. They
belong to facets, not to places, so a cage that is moved about takes its flow along, and the flow
stays divergence-free."""
import numpy as np

from . import library
from .problems import Problem

_FLUX, _BOUNDARY = "octetvdb_flux", "octetvdb_boundary"


def store(cage, flux, boundary="auto"):
    """Fluxes along the facets' stored orientation, and how the boundary refines."""
    cage.data[_FLUX] = np.asarray(flux, float)
    cage.data[_BOUNDARY] = boundary


def load(cage, control):
    """The fluxes and the boundary's mode."""
    if _FLUX not in cage.data:
        raise Problem(f'"{cage.name}" has no flow yet: fit it to guides first')
    flux = np.array(cage.data[_FLUX].to_list())
    if len(flux) != control.complex.facet_count:
        raise Problem(f'the flow of "{cage.name}" belongs to another cage: fit it again')
    return flux, cage.data[_BOUNDARY]


def exists(cage):
    return _FLUX in cage.data


def about(context, cage):
    """What a cage's control asset says of the scene."""
    scene = context.scene
    return {"name": cage.name, "with_density": cage.octetvdb.with_density,
            "meters_per_unit": scene.unit_settings.scale_length or 1.0,
            "frames_per_second": scene.render.fps / scene.render.fps_base}


def make_asset(control, about, flux=None, frames=None):
    """A control asset with form "velocity", constant or by frame, and "density" when asked for.
    Needs nothing of Blender's, so it runs on any thread."""
    octetvdb = library.need()
    forms = [octetvdb.Form(control, "velocity", 2, flux, frames=frames, unit="m/s")]
    about = dict(about)
    if about.pop("with_density"):
        forms.append(octetvdb.Form(control, "density", 0, np.ones(control.complex.vertex_count)))
    return octetvdb.ControlAsset(control, forms, **about)
