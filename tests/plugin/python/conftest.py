# SPDX-License-Identifier: Apache-2.0
"""Meshes and forms that the tests of the Python module share. PYTHONPATH names the build tree."""
import os
import sys

import numpy as np
import pytest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../samples"))
import octet_asset

import octetvdb

FLOW = np.array([0.25, -1.5, 0.75])
SLOPE = np.array([1.0, -2.0, 0.5])


def box_mesh(cells=(2, 3, 2), size=(2.0, 3.0, 1.5)):
    """A creased box of tetrahedra: flat walls, on which constants are exact."""
    cage = octet_asset.box(cells, size)
    return octetvdb.ControlMesh(cage.vertices, cage.tetrahedra)


def lattice_mesh(radius=2):
    """Tetrahedra and octahedra of the face-centred cubic lattice."""
    cage = octet_asset.lattice(lambda p: sum(map(abs, p)) <= radius, radius)
    return octetvdb.ControlMesh(cage.vertices, cage.tetrahedra, cage.octahedra)


def fluxes(mesh, flow=FLOW):
    """The 2-form of a constant field."""
    a, b, c = (mesh.vertices[mesh.complex.facets[:, k]] for k in range(3))
    return np.cross(b - a, c - a) @ np.asarray(flow, float) / 2


def circulations(mesh, slope=SLOPE):
    """The 1-form of a constant field."""
    a, b = (mesh.vertices[mesh.complex.edges[:, k]] for k in range(2))
    return (b - a) @ np.asarray(slope, float)


@pytest.fixture(scope="session")
def box():
    return box_mesh()


@pytest.fixture(scope="session")
def lattice():
    return lattice_mesh()


@pytest.fixture(scope="session")
def flow_asset(box):
    return octetvdb.ControlAsset(box, [octetvdb.Form(box, "flow", 2, fluxes(box), unit="m/s")],
                                 name="constant")
