# SPDX-License-Identifier: Apache-2.0
"""What the module computes is the library's: numbering, derivative, refinement, limits, fields,
control assets in files, bakes that equal the command line's."""
import hashlib
import inspect
import json
import os
import subprocess

import numpy as np
import pyopenvdb
import pytest

import octetvdb
from conftest import FLOW, SLOPE, circulations, fluxes

OCTETVDB = os.environ["OCTETVDB_COMMAND"]


def test_numbering_is_lexicographic_and_lookups_agree(lattice):
    c = lattice.complex
    for rows, count in ((c.edges, c.edge_count), (c.facets, c.facet_count)):
        assert len(rows) == count
        assert (np.diff(rows, axis=1) > 0).all()
        assert np.array_equal(rows, np.array(sorted(map(tuple, rows.tolist()))))
    index, sign = lattice.edge_index(c.edges[::-1, ::-1])
    assert np.array_equal(index, np.arange(c.edge_count)[::-1]) and (sign == -1).all()
    index, sign = lattice.facet_index(c.facets[:, [1, 2, 0]])
    assert np.array_equal(index, np.arange(c.facet_count)) and (sign == 1).all()
    with pytest.raises(octetvdb.InputError, match=r"edges\[1\]"):
        lattice.edge_index([[*c.edges[0]], [0, 0]])
    with pytest.raises(octetvdb.InputError, match=r"facets\[0\].*out of range"):
        lattice.facet_index([[0, 1, 10**6]])


def test_euler_characteristic_and_boundary(lattice):
    c = lattice.complex
    assert c.vertex_count - c.edge_count + c.facet_count - c.cell_count == 1
    boundary = np.zeros(c.facet_count, int)
    boundary[c.boundary_facets] = 1
    assert np.array_equal(boundary, np.abs(c.outward_signs))
    # The outward fluxes of the identity field add up to three volumes.
    x = lattice.vertices
    total = 0
    for f in c.boundary_facets:
        p, q, r = x[c.facets[f]]
        total += c.outward_signs[f] * np.cross(q - p, r - p) @ (p + q + r) / 6
    assert total == pytest.approx(3 * lattice.cell_volumes.sum())


@pytest.mark.parametrize("degree", [0, 1])
def test_derivative_of_derivative_is_zero(lattice, degree):
    c = lattice.complex
    w = np.random.default_rng(1).normal(size=c.count(degree))
    dd = c.derivative(degree + 1, c.derivative(degree, w))
    assert np.abs(dd).max() < 1e-14 * np.abs(w).max() * 10
    with pytest.raises(octetvdb.InputError):
        c.derivative(3, np.zeros(c.cell_count))


@pytest.mark.parametrize("boundary", ["walls", "open", "expansion"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_refinement_commutes_with_the_derivative(lattice, degree, boundary):
    refiner = octetvdb.Refiner(lattice, 2)
    w = np.random.default_rng(2).normal(size=lattice.complex.count(degree))
    first = refiner.complex().derivative(degree, refiner.refine(degree, w, boundary))
    second = refiner.refine(degree + 1, lattice.complex.derivative(degree, w), boundary)
    assert np.abs(first - second).max() < 1e-13


def test_steps_make_a_refinement(lattice):
    refiner = octetvdb.Refiner(lattice, 2)
    for degree in range(4):
        w = np.random.default_rng(3).normal(size=lattice.complex.count(degree))
        middle = refiner.step(0, degree, w, "open")
        assert len(middle) == refiner.complex(1).count(degree)
        assert np.array_equal(refiner.step(1, degree, middle, "open"),
                              refiner.refine(degree, w, "open"))
    with pytest.raises(octetvdb.InputError, match="level"):
        refiner.step(2, 0, np.zeros(3), "open")
    with pytest.raises(octetvdb.InputError, match="level"):
        refiner.positions(3)


def test_limits_of_constants(box):
    refiner = octetvdb.Refiner(box, 2)
    vectors = refiner.limit(2, refiner.refine(2, fluxes(box), "open"), "open")
    assert np.allclose(vectors, FLOW, atol=1e-11)
    vectors = refiner.limit(1, refiner.refine(1, circulations(box), "open"), "open")
    assert np.allclose(vectors, SLOPE, atol=1e-11)
    ones = refiner.limit(0, refiner.refine(0, np.ones(box.complex.vertex_count)), "walls")
    assert np.allclose(ones, 1, atol=1e-13) and ones.shape == (len(refiner.limit_positions()),)
    # Masses are kept exactly; on an irregular cage the cells' volumes change a little differently.
    masses = refiner.refine(3, box.cell_volumes)
    assert masses.sum() == pytest.approx(box.cell_volumes.sum(), rel=1e-13)
    density = refiner.limit(3, masses, "walls")
    assert density.shape == ones.shape and np.median(density) == pytest.approx(1, abs=0.02)


def test_fields_of_constants(box):
    refiner = octetvdb.Refiner(box, 1)
    points = np.random.default_rng(4).uniform(-1, 1, (200, 3)) * [0.99, 1.49, 0.74]
    for degree, w, expected in ((2, fluxes(box), FLOW), (1, circulations(box), SLOPE)):
        field = refiner.field(degree, w)
        values, inside = field.sample(points)
        assert inside.all() and np.allclose(values, expected, atol=1e-11)
        assert np.allclose(field.bounds, [[-1, -1.5, -0.75], [1, 1.5, 0.75]])
        assert field.components == 3
    outside = points + [3, 0, 0]
    values, inside = field.sample(outside)
    assert not inside.any() and not values.any()


def test_assets_survive_files(tmp_path, lattice):
    rng = np.random.default_rng(5)
    frames = {1: rng.normal(size=lattice.complex.edge_count),
              7: rng.normal(size=lattice.complex.edge_count)}
    frames[1][::3] = 0
    forms = [octetvdb.Form(lattice, f"form {k}", k, rng.normal(size=lattice.complex.count(k)),
                           unit="m") for k in range(4)]
    forms.append(octetvdb.Form(lattice, "animated", 1, frames=frames))
    asset = octetvdb.ControlAsset(lattice, forms, name="all", up_axis="Y", meters_per_unit=0.01,
                                  frames_per_second=30)
    for name in ("a.octet.json", "a.octet"):
        path = str(tmp_path / name)
        asset.write(path)
        read = octetvdb.ControlAsset.read(path)
        assert (read.name, read.up_axis, read.meters_per_unit, read.frames_per_second) == \
            ("all", "Y", 0.01, 30)
        assert read.frame_range == (1, 7)
        assert np.array_equal(read.mesh.vertices, lattice.vertices)
        assert np.array_equal(read.mesh.octahedra, lattice.octahedra)
        assert np.array_equal(read.mesh.creases, lattice.creases)
        assert np.array_equal(read.mesh.corners, lattice.corners)
        for form in forms[:4]:
            found = read.form(form.name)
            assert (found.degree, found.unit) == (form.degree, "m")
            assert np.array_equal(found.coefficients(), form.coefficients())
        for frame, values in frames.items():
            assert np.array_equal(read.form("animated").coefficients(frame), values)
        assert read.form("animated").frames == [1, 7]
        assert np.array_equal(read.form("animated").coefficients(5), frames[1])
        # An asset read from a file can be built upon.
        octetvdb.ControlAsset(read.mesh, read.forms[:2])


def test_bad_assets_are_refused(tmp_path, box, lattice):
    form = octetvdb.Form(box, "w", 2, fluxes(box))
    with pytest.raises(octetvdb.InputError, match="another mesh"):
        octetvdb.ControlAsset(lattice, [form])
    with pytest.raises(octetvdb.InputError, match="twice"):
        octetvdb.ControlAsset(box, [form, form])
    with pytest.raises(octetvdb.InputError, match="up_axis"):
        octetvdb.ControlAsset(box, up_axis="X")
    with pytest.raises(octetvdb.InputError, match="meters_per_unit"):
        octetvdb.ControlAsset(box, meters_per_unit=0)
    with pytest.raises(octetvdb.InputError, match="degree"):
        octetvdb.Form(box, "w", 4, fluxes(box))
    with pytest.raises(octetvdb.InputError, match="1e30"):
        octetvdb.Form(box, "w", 2, fluxes(box) * 1e31)
    for name in ("", "a\nb"):
        with pytest.raises(octetvdb.InputError, match="name"):
            octetvdb.Form(box, name, 2, fluxes(box))
    with pytest.raises(octetvdb.InputError, match="missing"):
        octetvdb.Form(box, "w", 2)
    with pytest.raises(octetvdb.InputError, match="frames"):
        octetvdb.Form(box, "w", 2, frames={})
    with pytest.raises(octetvdb.InputError, match=r"frames\[-10000000\]"):
        octetvdb.Form(box, "w", 2, frames={-10000000: fluxes(box)})
    with pytest.raises((TypeError, RuntimeError)):
        octetvdb.Form(box, "w", 2, frames={"one": fluxes(box)})
    with pytest.raises(octetvdb.InputError, match="there is no form") as caught:
        octetvdb.ControlAsset(box, [form]).form("v")
    assert "w" in caught.value.reason
    path = tmp_path / "bad.octet.json"
    path.write_text('{"octet": 1, "vertices": [[0, 0, 0]], "tetrahedra": [[0, 1, 2, 3]]}')
    with pytest.raises(octetvdb.InputError) as caught:
        octetvdb.ControlAsset.read(str(path))
    assert caught.value.file == str(path) and caught.value.place == "tetrahedra[0]"
    assert "out of range" in caught.value.reason
    assert str(caught.value) == f"{path}: tetrahedra[0]: {caught.value.reason}"
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, octetvdb.Error)


@pytest.mark.parametrize("boundary", ["projection", "expansion"])
def test_boundary_methods_keep_a_constant_flow(lattice, boundary):
    refiner = octetvdb.Refiner(lattice, 1)
    velocity = np.array([1.0, -2.0, 0.5])

    def fluxes(complex, x):
        a, b, c = (x[complex.facets[:, k]] for k in range(3))
        return np.cross(b - a, c - a) @ velocity / 2

    coarse = fluxes(lattice.complex, np.asarray(refiner.positions(0)))
    fine = refiner.refine(2, coarse, boundary)
    x = np.asarray(refiner.positions(boundary=boundary))
    assert np.abs(fine - fluxes(refiner.complex(), x)).max() < 1e-12
    assert np.abs(x - refiner.positions(boundary="simple")).max() > 0.01  # which shrinks
    vectors, inside = refiner.field(2, coarse, boundary).sample(x.mean(axis=0, keepdims=True))
    assert inside.all() and np.allclose(vectors, velocity, atol=1e-10)


def test_limit_positions_are_limits_of_positions(lattice):
    refiner = octetvdb.Refiner(lattice, 2)
    kept = refiner.limit_positions()
    for axis in range(3):
        limits = refiner.limit(0, refiner.positions()[:, axis], "walls")
        assert np.allclose(kept[:, axis], limits, atol=1e-14)


def grids_of(path):
    """Everything a .vdb stores: transform, metadata without statistics, active values."""
    result = {}
    for grid in pyopenvdb.readAll(path)[0]:
        values = sorted((item.min, item.max, item.value) for item in grid.iterOnValues())
        result[grid.name] = (grid.transform.info(), sorted(map(str, grid.metadata.items())),
                             hashlib.sha256(repr(values).encode()).hexdigest())
    return result


@pytest.mark.parametrize("options", [
    {}, {"target": "blender"}, {"target": "houdini", "half": True}, {"grid": "staggered"},
    {"reconstruction": "whitney"}, {"grid": "staggered", "method": "samples"},
    {"method": "conservative"}, {"project": True}, {"boundary": "open", "levels": 1}, {"zeta": -6.0},
    {"boundary": "simple", "grid": "staggered"}, {"boundary": "projection"},
    {"boundary": "expansion", "grid": "staggered"},
])
def test_bakes_equal_the_command_line_s(tmp_path, flow_asset, options):
    control = str(tmp_path / "a.octet.json")
    flow_asset.write(control)
    mine, theirs = str(tmp_path / "mine.vdb"), str(tmp_path / "theirs.vdb")
    report = octetvdb.bake(flow_asset, mine, voxel_size=0.1, **options)
    arguments = []
    for key, value in options.items():
        option = f"--{key}"
        arguments += [option] if value is True else [option, str(value)]
    done = subprocess.run([OCTETVDB, "bake", control, "-o", theirs, "--voxel-size", "0.1", "--json",
                           *arguments], check=True, capture_output=True, text=True)
    summary = json.loads(done.stdout)
    assert grids_of(mine) == grids_of(theirs)
    assert (report.levels, report.cells, report.note) == \
        (summary["levels"], summary["cells"], summary["note"])
    assert report.mean_edge == pytest.approx(summary["mean_edge"], rel=1e-12)
    (grid,), (told,) = report.files[0].grids, summary["files"][0]["grids"]
    assert (grid.name, grid.type, grid.active_voxels, list(grid.index_min), grid.half) == \
        (told["name"], told["type"], told["active_voxels"], told["index_min"], told["half"])
    assert (grid.method, grid.sampled_voxels) == (told["method"], told["sampled_voxels"])
    if options.get("method") == "conservative":
        assert grid.method == "circulations" and 0 < grid.sampled_voxels < grid.active_voxels
    (read,) = octetvdb.read_grid_info(mine)
    assert (read.name, read.active_voxels) == (grid.name, grid.active_voxels)
    assert grid.metadata["octet_form"] == "flow"


def test_certificates_are_what_verify_finds(tmp_path, flow_asset):
    path = str(tmp_path / "a.vdb")
    for options in ({}, {"grid": "staggered"}, {"half": True}):
        (grid,) = octetvdb.bake(flow_asset, path, voxel_size=0.1, **options).files[0].grids
        (found,) = octetvdb.verify(path)
        (named,) = octetvdb.verify(path, "flow")
        assert found.name == "flow" and found.voxel_size == pytest.approx(0.1)
        for member in (m for m in dir(grid.certificate) if not m.startswith("_")):
            assert getattr(grid.certificate, member) == getattr(found.certificate, member), member
            assert getattr(named.certificate, member) == getattr(found.certificate, member), member
        assert found.certificate.half == ("half" in options)
        assert found.certificate.max_divergence < (1e-3 if "half" in options else 2e-6)
    (read,) = octetvdb.read_grid_info(path)
    assert read.certificate is None
    with pytest.raises(octetvdb.InputError, match="other"):
        octetvdb.verify(path, "other")
    with pytest.raises(octetvdb.InputError):
        octetvdb.verify(str(tmp_path / "missing.vdb"))


def test_animated_bakes_make_a_sequence(tmp_path, box):
    frames = {1: fluxes(box), 3: 2 * fluxes(box)}
    asset = octetvdb.ControlAsset(box, [octetvdb.Form(box, "flow", 2, frames=frames)])
    report = octetvdb.bake(asset, str(tmp_path / "a.vdb"), resolution=8, frames="2-3")
    assert [f.frame for f in report.files] == [2, 3]
    assert [os.path.basename(f.path) for f in report.files] == ["a.0002.vdb", "a.0003.vdb"]
    speeds = [f.grids[0].max for f in report.files]
    assert speeds[1] == pytest.approx(2 * speeds[0])


def test_shards_make_the_whole(tmp_path, flow_asset):
    path = {name: str(tmp_path / f"{name}.vdb") for name in ("whole", "one", "two", "merged")}
    octetvdb.bake(flow_asset, path["whole"], resolution=40)
    for number, name in ((1, "one"), (2, "two")):
        report = octetvdb.bake(flow_asset, path[name], resolution=40, shard=(number, 2))
        assert report.part == f"shard {number} of 2"
        assert report.files[0].grids[0].certificate.partial
    merged = octetvdb.merge([path["two"], path["one"]], path["merged"])
    assert merged.path == path["merged"] and merged.frame is None
    assert not merged.grids[0].certificate.partial
    with open(path["whole"], "rb") as whole, open(path["merged"], "rb") as again:
        assert whole.read() == again.read()
    with pytest.raises(octetvdb.InputError, match="missing: 2"):
        octetvdb.merge([path["one"]], path["merged"])
    report = octetvdb.bake(flow_asset, path["one"], resolution=40, region=(0, 0, 0, 0.2, 0.2, 0.2))
    assert report.part == "region"
    for options in ({"region": (0, 0, 0, -1, 1, 1)}, {"shard": (3, 2)},
                    {"region": (0, 0, 0, 1, 1, 1), "shard": (1, 2)}):
        with pytest.raises(octetvdb.InputError, match="region|shard"):
            octetvdb.bake(flow_asset, path["one"], resolution=40, **options)


def test_more_memory_than_there_is(tmp_path, flow_asset):
    with pytest.raises(octetvdb.MemoryError, match="largest resolution that fits is [0-9]+"):
        octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=30000, levels=0)
    assert os.listdir(tmp_path) == []


def test_bad_bakes_are_refused_and_write_nothing(tmp_path, flow_asset):
    out = str(tmp_path / "out.vdb")
    for options, reason in (({}, "voxel size"), ({"voxel_size": 1, "resolution": 2}, "voxel size"),
                            ({"voxel_size": -1}, "voxel size"),
                            ({"voxel_size": float("nan")}, "voxel size"),
                            ({"resolution": 8, "target": "maya"}, "target"),
                            ({"resolution": 8, "boundary": "periodic"}, "boundary"),
                            ({"resolution": 8, "grid": "hexagonal"}, "grid"),
                            ({"resolution": 8, "reconstruction": "cubic"}, "reconstruction"),
                            ({"resolution": 8, "forms": ["vorticity"]}, "no form"),
                            ({"resolution": 8, "frames": (1, 2)}, "frames"),
                            ({"resolution": 8, "levels": 40}, "levels")):
        with pytest.raises(octetvdb.InputError, match=reason):
            octetvdb.bake(flow_asset, out, **options)
    with pytest.raises(octetvdb.IoError) as caught:
        octetvdb.bake(flow_asset, str(tmp_path / "missing" / "out.vdb"), resolution=8)
    assert caught.value.file.endswith("out.vdb") and isinstance(caught.value, OSError)
    with pytest.raises(octetvdb.IoError):
        octetvdb.bake(flow_asset, str(tmp_path), resolution=8)
    with pytest.raises(octetvdb.InputError, match="name it out.vdb"):
        octetvdb.bake(flow_asset, str(tmp_path / "out.abc"), resolution=8)
    with pytest.raises(octetvdb.InputError):
        octetvdb.read_grid_info(out)
    assert os.listdir(tmp_path) == []


def test_everything_is_documented_and_typed():
    """The stubs list what the module has, no more and no less, and all of it has docstrings."""
    import ast
    folder = os.path.dirname(octetvdb.__file__)
    with open(os.path.join(folder, "_octetvdb.pyi")) as file:
        tree = ast.parse(file.read())
    from octetvdb import _octetvdb as compiled
    stubs = {node.name: node for node in tree.body
             if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    public = {name for name in dir(compiled) if not name.startswith("_")}
    values = {node.target.id for node in tree.body if isinstance(node, ast.AnnAssign)
              and not node.target.id.startswith("_")}
    assert values <= public
    public -= values
    assert set(stubs) == public
    assert public | values | {"__version__", "from_meshio", "preview", "to_meshio"} == set(octetvdb.__all__)
    for name, node in stubs.items():
        thing = getattr(compiled, name)
        assert thing.__doc__, name
        if isinstance(node, ast.FunctionDef):
            arguments = [a.arg for a in node.args.args + node.args.kwonlyargs]
            for argument in arguments:
                assert f"{argument}:" in thing.__doc__.split("\n")[0], (name, argument)
        elif not issubclass(thing, Exception):
            members = {m.name for m in node.body if isinstance(m, ast.FunctionDef)}
            own = {m for m in vars(thing) if not m.startswith("_")}
            assert {m for m in members if not m.startswith("_")} == own, name
            for member in own:
                assert inspect.getdoc(getattr(thing, member)), (name, member)
