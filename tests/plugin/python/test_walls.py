# SPDX-License-Identifier: Apache-2.0
"""The smooth wall (SCHEME.md section 8b) against its slow version, and what holds of it anywhere."""
import os
import sys

import numpy as np
import pytest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../support/slow"))
import walls

import octetvdb
from conftest import box_mesh, lattice_mesh

SAMPLES = os.path.join(HERE, "../../../samples")


def ball():
    return octetvdb.ControlAsset.read(os.path.join(SAMPLES, "ball/ball.octet.json")).mesh


def smooth_box():
    mesh = box_mesh((2, 2, 2), (2.0, 2.0, 2.0))
    return octetvdb.ControlMesh(mesh.vertices, mesh.tetrahedra, creases=[], corners=[0])


def rounded_lattice():
    """Octahedra at walls, no creases."""
    mesh = lattice_mesh()
    return octetvdb.ControlMesh(mesh.vertices, mesh.tetrahedra, mesh.octahedra, creases=[])


MESHES = {"ball": ball, "creased box": box_mesh, "smooth box": smooth_box, "lattice": lattice_mesh,
          "rounded lattice": rounded_lattice}


@pytest.fixture(scope="module", params=MESHES)
def pair(request):
    """Two levels with a smooth wall, and with Loop's."""
    mesh = MESHES[request.param]()
    return [octetvdb.Refiner(mesh, 2, wall_surface=rows) for rows in ("smooth", "loop")]


class Slow:
    """What the wall's rule adds to a 0-form of level 1 when it is split."""

    def __init__(self, refiner):
        mesh, complex, control = refiner.mesh, refiner.complex(1), refiner.complex(0)
        number = {frozenset(e): k for k, e in enumerate(control.edges.tolist())}
        creases = []
        for edge in mesh.creases.tolist():
            middle = len(mesh.vertices) + number[frozenset(edge)]
            creases += [(v, middle) for v in edge]
        self.asked = walls.claims(walls.Mesh(complex.tetrahedra.tolist(),
                                             complex.octahedra.tolist(), creases,
                                             mesh.corners.tolist()))
        self.edges = {frozenset(e): k for k, e in enumerate(complex.edges.tolist())}
        self.vertices = complex.vertex_count
        self.first_oct = len(complex.tetrahedra)
        self.size = refiner.complex(2).vertex_count

    def fine(self, name):
        kind, which = name
        if kind == "v":
            return which
        if kind == "e":
            return self.vertices + self.edges[which]
        return self.vertices + len(self.edges) + which - self.first_oct

    def leave_out(self, moved):
        """Drops the stars whose moves were not made: of all that only they ask for, nothing is there."""
        askers = {}
        for m, star in self.asked.items():
            for name in star:
                askers.setdefault(name, []).append(m)
        out = []
        for m, star in self.asked.items():
            own = [moved[self.fine(name)] for name in star if len(askers[name]) == 1]
            if own and not np.any(np.abs(own) > 1e-14):
                out.append(m)
        for m in out:
            del self.asked[m]
        return len(out)

    def moves(self, values):
        result = np.zeros(self.size)
        for name, row in walls.moves(self.asked).items():
            result[self.fine(name)] = sum(w * values[v] for v, w in row.items())
        return result


def test_agrees_with_the_slow_version(pair):
    smooth, loop = pair
    rng = np.random.default_rng(1)
    values = rng.normal(size=len(smooth.positions(1)))
    moved = smooth.step(1, 0, values, "walls") - loop.step(1, 0, values, "walls")
    slow = Slow(smooth)
    asked = len(slow.asked)
    assert slow.leave_out(moved) < max(asked, 1)  # stars whose cells would be flattened
    assert np.abs(moved - slow.moves(values)).max() < 1e-11


def test_first_split_is_loops(pair):
    smooth, loop = pair
    assert np.array_equal(smooth.positions(1), loop.positions(1))


def test_moves_something_where_the_wall_is_smooth_and_irregular(pair):
    smooth, loop = pair
    flat = len(smooth.mesh.creases) > 0
    distance = np.abs(smooth.positions(2) - loop.positions(2)).max()
    assert distance > 1e-6 or flat


def test_commutes_and_walls_stay_tight(pair):
    rng = np.random.default_rng(2)
    for refiner in pair:
        for degree in (0, 1, 2):
            size = [len(refiner.mesh.vertices), len(refiner.complex(0).edges),
                    len(refiner.complex(0).facets)][degree]
            form = rng.normal(size=size)
            for mode in ("walls", "open"):
                one = refiner.complex(2).derivative(degree, refiner.refine(degree, form, mode))
                other = refiner.refine(degree + 1, refiner.complex(0).derivative(degree, form), mode)
                assert np.abs(one - other).max() < 1e-12 * max(1, np.abs(other).max())
        flux = rng.normal(size=len(refiner.complex(0).facets))
        flux[refiner.complex(0).boundary_facets] = 0
        fine = refiner.refine(2, flux, "walls")
        assert not fine[refiner.complex(2).boundary_facets].any()


def test_a_wall_that_is_flat_stays(pair):
    smooth, _ = pair
    box = smooth.mesh
    if len(box.creases) == 0 or len(box.octahedra):
        return
    low, high = box.vertices.min(0), box.vertices.max(0)
    fine = smooth.positions(2)
    on = np.unique(smooth.complex(2).facets[smooth.complex(2).boundary_facets])
    off = np.minimum(np.abs(fine[on] - low), np.abs(fine[on] - high)).min(1)
    assert off.max() < 1e-13


def test_unknown_name():
    with pytest.raises(octetvdb.InputError, match="none of smooth, loop"):
        octetvdb.Refiner(ball(), 1, wall_surface="flat")
