# SPDX-License-Identifier: Apache-2.0
"""meshio meshes both ways: in memory exactly, through files as far as the format goes."""
import meshio
import numpy as np
import pytest

import octetvdb
from conftest import box_mesh, fluxes


@pytest.fixture
def asset(lattice):
    rng = np.random.default_rng(8)
    forms = [octetvdb.Form(lattice, f"w{k}", k, rng.normal(size=lattice.complex.count(k)))
             for k in range(4)]
    return octetvdb.ControlAsset(lattice, forms, name="lattice")


def same_octahedra(a, b):
    """Equal up to which pole comes first and where the ring starts."""
    def key(o):
        return sorted([sorted([o[0], o[5]]), sorted([o[1], o[3]]), sorted([o[2], o[4]])])
    return [key(o) for o in a.tolist()] == [key(o) for o in b.tolist()]


def assert_same(a, b):
    assert np.array_equal(a.mesh.vertices, b.mesh.vertices)
    assert np.array_equal(a.mesh.tetrahedra, b.mesh.tetrahedra)
    assert same_octahedra(a.mesh.octahedra, b.mesh.octahedra)
    for form in a.forms:
        assert np.allclose(b.form(form.name).coefficients(), form.coefficients(), rtol=1e-15,
                           atol=0), form.name


def test_round_trip_in_memory(asset):
    back = octetvdb.from_meshio(octetvdb.to_meshio(asset), name="lattice")
    assert_same(asset, back)
    assert np.array_equal(back.mesh.creases, asset.mesh.creases)
    assert np.array_equal(back.mesh.corners, asset.mesh.corners)
    assert back.name == "lattice"


def test_a_smooth_mesh_stays_smooth(lattice):
    smooth = octetvdb.ControlMesh(lattice.vertices, lattice.tetrahedra, lattice.octahedra,
                                  creases=[])
    back = octetvdb.from_meshio(octetvdb.to_meshio(octetvdb.ControlAsset(smooth)))
    assert len(back.mesh.creases) == 0


@pytest.mark.parametrize("file_format", ["vtu", "vtk"])
def test_round_trip_through_files(tmp_path, asset, file_format):
    path = str(tmp_path / "a")
    meshio.write(path, octetvdb.to_meshio(asset), file_format=file_format)
    assert_same(asset, octetvdb.from_meshio(meshio.read(path, file_format=file_format)))


def test_pyramids_have_positive_volume(lattice):
    mesh = octetvdb.to_meshio(octetvdb.ControlAsset(lattice))
    (pyramids,) = [block.data for block in mesh.cells if block.type == "pyramid"]
    p = mesh.points[pyramids]
    normal = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) / 2
    volumes = np.einsum("ij,ij->i", normal, p[:, 4] - p[:, 0]) / 3
    assert (volumes > 0).all()
    octahedra = lattice.cell_volumes[len(lattice.tetrahedra):]
    assert np.allclose(volumes.reshape(-1, 2).sum(axis=1), octahedra)


def test_a_tetrahedral_mesh_made_by_others():
    """Points of no cell are dropped; integer tags and vectors are no forms."""
    mesh = box_mesh()
    points = np.vstack([[[9, 9, 9]], mesh.vertices])
    flux = fluxes(mesh)
    # Triangles the other way round carry the opposite coefficient.
    found = meshio.Mesh(points, [("triangle", mesh.complex.facets[:, ::-1] + 1),
                                 ("tetra", mesh.tetrahedra + 1)],
                        point_data={"height": points[:, 2], "where": points},
                        cell_data={"flow": [-flux, np.full(len(mesh.tetrahedra), np.nan)],
                                   "gmsh:physical": [np.ones(len(flux)),
                                                     np.ones(len(mesh.tetrahedra))],
                                   "part": [np.ones(len(flux), int),
                                            np.ones(len(mesh.tetrahedra), int)]})
    asset = octetvdb.from_meshio(found)
    assert [f.name for f in asset.forms] == ["height", "flow"]
    assert np.array_equal(asset.mesh.vertices, mesh.vertices)
    assert np.allclose(asset.form("flow").coefficients(), flux)
    assert np.array_equal(asset.form("height").coefficients(), mesh.vertices[:, 2])


def test_bad_meshes_are_refused(asset):
    good = octetvdb.to_meshio(asset)
    with pytest.raises(octetvdb.InputError, match="no tetrahedra"):
        octetvdb.from_meshio(meshio.Mesh(good.points, [("triangle", [[0, 1, 2]])]))
    with pytest.raises(octetvdb.InputError, match="out of range"):
        octetvdb.from_meshio(meshio.Mesh(good.points, [("tetra", [[0, 1, 2, 10**6]])]))
    with pytest.raises(octetvdb.InputError, match="pyramid 0 shares"):
        octetvdb.from_meshio(meshio.Mesh(
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1.0]],
            [("pyramid", [[0, 1, 2, 3, 4]])]))
    mixed = meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]],
                        [("line", [[0, 1]]), ("tetra", [[0, 1, 2, 3]])],
                        cell_data={"w": [np.ones(1), np.ones(1)]})
    with pytest.raises(octetvdb.InputError, match="several dimensions"):
        octetvdb.from_meshio(mixed)
