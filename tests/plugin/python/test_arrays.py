# SPDX-License-Identifier: Apache-2.0
"""Arrays in: every dtype, byte order, stride and shape means the same numbers or is refused. Arrays
out: views that cannot be written and keep their owner alive."""
import gc
import weakref

import numpy as np
import pytest

import octetvdb
from conftest import FLOW, box_mesh, fluxes, lattice_mesh

# Positions that all number types hold exactly.
TETRAHEDRON = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 1]])
REAL_DTYPES = ["b", "B", "h", "H", "i", "I", "l", "L", "q", "Q", "e", "f", "d", "g",
               ">f8", "<f8", ">f4", ">i4", "<i2"]
INTEGER_DTYPES = ["b", "B", "h", "H", "i", "I", "l", "L", "q", "Q", ">i4", ">i8", "<u2"]


def layouts(array):
    """The same array in every memory layout."""
    array = np.asarray(array)
    yield "contiguous", np.ascontiguousarray(array)
    yield "fortran", np.asfortranarray(array)
    wide = np.zeros(tuple(2 * n for n in array.shape), array.dtype)
    inner = wide[tuple(slice(None, None, 2) for _ in array.shape)]
    inner[...] = array
    yield "strided", inner
    yield "reversed", np.ascontiguousarray(array[::-1])[::-1]
    raw = bytearray(array.nbytes + 1)
    shifted = np.frombuffer(raw, np.uint8)[1:].view(array.dtype).reshape(array.shape)
    shifted[...] = array
    yield "unaligned", shifted
    frozen = array.copy()
    frozen.flags.writeable = False
    yield "read-only", frozen
    yield "broadcast", np.broadcast_to(array, array.shape)
    yield "list", array.tolist()


@pytest.mark.parametrize("dtype", REAL_DTYPES)
def test_vertices_of_every_dtype_and_layout(dtype):
    for name, array in layouts(TETRAHEDRON.astype(dtype)):
        mesh = octetvdb.ControlMesh(array, [[0, 1, 2, 3]])
        assert np.array_equal(mesh.vertices, TETRAHEDRON), name


@pytest.mark.parametrize("dtype", INTEGER_DTYPES)
def test_indices_of_every_dtype_and_layout(dtype):
    for name, array in layouts(np.array([[3, 1, 2, 0]]).astype(dtype)):
        mesh = octetvdb.ControlMesh(TETRAHEDRON, array)
        assert np.array_equal(mesh.tetrahedra, [[3, 1, 2, 0]]), name


@pytest.mark.parametrize("dtype", ["f", "d", "e", ">f8", "i"])
def test_points_of_every_layout_sample_alike(box, dtype):
    field = octetvdb.Refiner(box).field(2, fluxes(box))
    points = np.array([[0, 0, 0], [1, 1, 0], [-1, 1, 0.5], [5, 5, 5]]).astype(dtype)
    expected, inside = field.sample(points.astype(float))
    for name, array in layouts(points):
        values, flags = field.sample(array)
        assert np.array_equal(values, expected) and np.array_equal(flags, inside), name


def test_values_of_every_layout_refine_alike(box):
    refiner = octetvdb.Refiner(box)
    w = fluxes(box).astype("f4")
    expected = refiner.refine(2, w.astype(float))
    for name, array in layouts(w):
        assert np.array_equal(refiner.refine(2, array), expected), name


@pytest.mark.parametrize("bad", [
    np.array([[0j, 0, 0]]), np.array([["a", "b", "c"]]), np.array([[None, 1, 2]], object),
    np.array([["2020-01-01"] * 3], "datetime64[D]"), [[0, 0, 0], [1, 2]], "points", {1: 2},
    [[b"x", b"y", b"z"]],
])
def test_no_numbers_are_a_type_error(box, bad):
    field = octetvdb.Refiner(box).field(2, fluxes(box))
    with pytest.raises((TypeError, octetvdb.InputError)):
        field.sample(bad)
    with pytest.raises((TypeError, octetvdb.InputError)):
        octetvdb.ControlMesh(bad, [[0, 1, 2, 3]])


def test_indices_that_are_no_integers_are_a_type_error():
    for bad in (np.array([[0.0, 1, 2, 3]]), np.array([[True, False, True, False]]),
                np.array([["0", "1", "2", "3"]])):
        with pytest.raises(TypeError):
            octetvdb.ControlMesh(TETRAHEDRON, bad)


@pytest.mark.parametrize("value", [-1, 4, 2**31, -2**31 - 1, 2**63 - 1])
def test_indices_out_of_range_are_refused(value):
    with pytest.raises(octetvdb.InputError, match=r"tetrahedra\[0\].*out of range"):
        octetvdb.ControlMesh(TETRAHEDRON, np.array([[0, 1, 2, value]], np.int64))


def test_unsigned_indices_do_not_wrap():
    with pytest.raises(octetvdb.InputError, match="out of range"):
        octetvdb.ControlMesh(TETRAHEDRON, np.array([[0, 1, 2, 2**64 - 1]], np.uint64))
    with pytest.raises(octetvdb.InputError, match="out of range"):
        octetvdb.ControlMesh(TETRAHEDRON, np.array([[0, 1, 2, 2**32 - 1]], np.uint32))


@pytest.mark.parametrize("shape", [(), (3,), (4, 2), (4, 4), (3, 4), (1, 4, 3), (0,), (0, 3)])
def test_vertices_of_other_shapes_are_refused(shape):
    with pytest.raises(octetvdb.InputError):
        octetvdb.ControlMesh(np.zeros(shape), [[0, 1, 2, 3]])


@pytest.mark.parametrize("shape", [(), (4,), (1, 3), (1, 5), (4, 1), (1, 1, 4)])
def test_cells_of_other_shapes_are_refused(shape):
    with pytest.raises(octetvdb.InputError, match="shape"):
        octetvdb.ControlMesh(TETRAHEDRON, np.zeros(shape, int))


@pytest.mark.parametrize("change", [-1, 1])
def test_coefficients_of_other_length_are_refused(lattice, change):
    refiner = octetvdb.Refiner(lattice)
    for degree in range(4):
        n = lattice.complex.count(degree)
        for wrong in (np.zeros(n + change), np.zeros((n, 1)), np.zeros(())):
            with pytest.raises(octetvdb.InputError, match=rf"\({n},\)"):
                refiner.refine(degree, wrong)
            with pytest.raises(octetvdb.InputError, match=rf"\({n},\)"):
                octetvdb.Form(lattice, "w", degree, wrong)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_with_its_place(box, bad):
    refiner = octetvdb.Refiner(box)
    w = fluxes(box)
    w[7] = bad
    for call in (lambda: refiner.refine(2, w), lambda: octetvdb.Form(box, "w", 2, w),
                 lambda: refiner.field(2, w), lambda: box.complex.derivative(2, w),
                 lambda: octetvdb.Form(box, "w", 2, frames={3: w})):
        with pytest.raises(octetvdb.InputError, match=r"\[7\].*not finite"):
            call()
    points = np.zeros((3, 4, 3))
    points[1, 2, 0] = bad
    with pytest.raises(octetvdb.InputError, match=r"points\[6\].*not finite"):
        refiner.field(2, fluxes(box)).sample(points)
    vertices = box.vertices.copy()
    vertices[5, 1] = bad
    with pytest.raises(octetvdb.InputError, match=r"vertices\[5\].*not finite"):
        octetvdb.ControlMesh(vertices, box.tetrahedra)


def test_points_of_any_leading_shape(box):
    field = octetvdb.Refiner(box).field(2, fluxes(box))
    for shape in ((), (1,), (5,), (2, 3), (2, 0, 3), (1, 2, 3, 4), (0,)):
        values, inside = field.sample(np.zeros(shape + (3,)))
        assert values.shape == shape + (3,) and inside.shape == shape
        assert inside.dtype == bool and values.dtype == float
        assert np.allclose(values, FLOW, atol=1e-12)
    scalar = octetvdb.Refiner(box).field(0, np.ones(box.complex.vertex_count))
    values, inside = scalar.sample(np.zeros((4, 2, 3)))
    assert values.shape == (4, 2) and np.allclose(values, 1)
    for bad in (np.zeros(()), np.zeros(2), np.zeros((3, 2)), np.zeros((3, 0))):
        with pytest.raises(octetvdb.InputError, match=r"\(\.\.\., 3\)"):
            field.sample(bad)


def views_of(mesh, refiner):
    complex_ = mesh.complex
    return [mesh.vertices, mesh.tetrahedra, mesh.octahedra, mesh.corners, complex_.edges,
            complex_.tetrahedra, complex_.octahedra, refiner.positions(0), refiner.positions(),
            refiner.limit_positions(), refiner.complex().edges]


def test_views_share_memory_and_cannot_be_written():
    mesh = box_mesh()
    refiner = octetvdb.Refiner(mesh)
    for first, second in zip(views_of(mesh, refiner), views_of(mesh, refiner)):
        if first.size == 0:
            continue
        assert not first.flags.writeable and not first.flags.owndata
        assert np.shares_memory(first, second)
        with pytest.raises(ValueError):
            first[...] = 0
        with pytest.raises(ValueError):
            first.flags.writeable = True


def test_views_keep_their_owner_alive():
    mesh = lattice_mesh()
    refiner = octetvdb.Refiner(mesh, 2)
    views = views_of(mesh, refiner)
    copies = [v.copy() for v in views]
    del mesh, refiner
    gc.collect()
    # New things would overwrite freed memory.
    rubbish = [octetvdb.Refiner(lattice_mesh(3), 2) for _ in range(3)]
    for view, copy in zip(views, copies):
        assert np.array_equal(view, copy)
    del rubbish


def test_a_field_outlives_what_made_it():
    mesh = box_mesh()
    refiner = octetvdb.Refiner(mesh, 2)
    field = refiner.field(2, fluxes(mesh))
    whitney = refiner.field(2, fluxes(mesh), reconstruction="whitney")
    del mesh, refiner
    gc.collect()
    for f in (field, whitney):
        values, inside = f.sample([[0.1, 0.2, 0.3]])
        assert inside[0] and np.allclose(values, FLOW, atol=0.3)


def test_forms_keep_the_asset_s_mesh_alive(tmp_path, flow_asset):
    path = str(tmp_path / "a.octet.json")
    flow_asset.write(path)
    mesh = octetvdb.ControlAsset.read(path).mesh
    form = octetvdb.ControlAsset.read(path).form("flow")
    gc.collect()
    assert np.allclose(mesh.vertices, flow_asset.mesh.vertices)
    assert np.array_equal(form.coefficients(), flow_asset.form("flow").coefficients())


def test_results_are_handed_over_and_die_with_their_array(box):
    refiner = octetvdb.Refiner(box)
    result = refiner.refine(2, fluxes(box))
    assert result.flags.writeable
    gone = weakref.ref(result)
    del result
    gc.collect()
    assert gone() is None


def test_input_arrays_are_left_alone(box):
    w = fluxes(box)
    before = w.copy()
    octetvdb.Refiner(box).refine(2, w)
    octetvdb.Form(box, "w", 2, w)
    assert np.array_equal(w, before) and w.flags.writeable
