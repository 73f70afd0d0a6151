# SPDX-License-Identifier: Apache-2.0
"""Cages, streamlines and pictures from the module are the library's."""
import os
import subprocess

import numpy as np
import pytest

import octetvdb
from conftest import FLOW, fluxes

OCTETVDB = os.environ["OCTETVDB_COMMAND"]


def sphere(rings=12, segments=16, radius=1.0):
    """A closed surface of triangles."""
    angles = np.pi * np.arange(1, rings) / rings
    turns = 2 * np.pi * np.arange(segments) / segments
    ring = np.stack([np.outer(np.sin(angles), np.cos(turns)), np.outer(np.sin(angles), np.sin(turns)),
                     np.outer(np.cos(angles), np.ones(segments))], axis=-1).reshape(-1, 3)
    vertices = np.vstack([[[0, 0, 1]], ring, [[0, 0, -1]]]) * radius
    triangles = []
    for k in range(segments):
        n = (k + 1) % segments
        triangles.append((0, 1 + k, 1 + n))
        for r in range(rings - 2):
            a = 1 + r * segments
            triangles += [(a + k, a + segments + k, a + segments + n), (a + k, a + segments + n, a + n)]
        last = 1 + (rings - 2) * segments
        triangles.append((last + k, len(vertices) - 1, last + n))
    return vertices, np.array(triangles)


def test_box_cage():
    mesh = octetvdb.box_cage([0, 0, 0], [2, 3, 1], 0.5)
    assert mesh.cell_volumes.sum() == pytest.approx(6)
    assert len(mesh.octahedra)
    # Creases run along the twelve edges of the box, each of which is straight.
    ends = mesh.vertices[mesh.creases]
    assert ((ends[:, 0] == ends[:, 1]).sum(axis=1) == 2).all()
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(4 * (2 + 3 + 1))
    quality = octetvdb.cage_quality(mesh)
    assert quality.components == 1 and quality.touching_edges == 0
    assert 0 < quality.min_dihedral < quality.max_dihedral <= 180
    for low, high, spacing in (([0, 0, 0], [0, 1, 1], 0.5), ([0, 0, 0], [1, 1, 1], 0),
                               ([0, 0, 0], [1, 1, 1], 1e-4), ([0, 0], [1, 1, 1], 0.5),
                               ([0, 0, np.nan], [1, 1, 1], 0.5)):
        with pytest.raises(octetvdb.InputError):
            octetvdb.box_cage(low, high, spacing)


@pytest.mark.parametrize("fit_boundary", [False, True])
def test_filled_surface_is_the_command_line_s(tmp_path, fit_boundary):
    vertices, triangles = sphere()
    vertices = vertices.astype(np.float32)  # as the .obj is read
    mesh = octetvdb.fill_surface(vertices, triangles, 0.4, fit_boundary=fit_boundary)
    surface, out = tmp_path / "sphere.obj", str(tmp_path / "cage.octet.json")
    with open(surface, "w") as file:
        for v in vertices:
            file.write("v " + " ".join(f"{x:.9g}" for x in v) + "\n")
        for t in triangles:
            file.write("f " + " ".join(str(i + 1) for i in t) + "\n")
    subprocess.run([OCTETVDB, "fill", surface, "-o", out, "--spacing", "0.4",
                    *(["--fit-boundary"] if fit_boundary else [])], check=True, capture_output=True)
    theirs = octetvdb.ControlAsset.read(out).mesh
    assert np.array_equal(theirs.octahedra, mesh.octahedra)
    assert np.allclose(theirs.vertices, mesh.vertices, rtol=0, atol=1e-12)
    radii = np.linalg.norm(mesh.vertices[np.unique(mesh.complex.facets[
        mesh.complex.boundary_facets])], axis=1)
    if fit_boundary:
        assert np.abs(radii - 1).max() < 0.06
    else:
        assert np.abs(radii - 1).max() < 0.5


def tetrahedra_or_skip(*arguments, **options):
    try:
        return octetvdb.fill_tetrahedra(*arguments, **options)
    except octetvdb.IoError as e:
        if "octetvdb-gmsh: is not installed" in str(e):
            pytest.skip("without octetvdb-gmsh")
        raise


def test_cages_keep_the_edges_of_a_cube():
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], float)
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    fitted = octetvdb.fill_surface(corners, triangles, 0.25, fit_boundary=True)
    ends = fitted.vertices[fitted.creases]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(12)
    assert len(octetvdb.fill_surface(corners, triangles, 0.25, fit_boundary=True,
                                     sharp_angle=91).creases) == 0
    mesh = tetrahedra_or_skip(corners, triangles, 0.4)
    assert len(mesh.octahedra) == 0
    assert mesh.cell_volumes.sum() == pytest.approx(1)
    ends = mesh.vertices[mesh.creases]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(12)
    assert octetvdb.cage_quality(mesh).min_dihedral > 10
    assert len(octetvdb.fill_tetrahedra(corners, triangles, 0.4, sharp_angle=91).creases) == 0
    kept = octetvdb.fill_tetrahedra(corners, triangles, 0.4, keep_triangles=True)
    assert len(kept.complex.boundary_facets) == 12
    with pytest.raises(octetvdb.InputError, match="not closed"):
        octetvdb.fill_tetrahedra(corners, triangles[1:], 0.4)
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.fill_tetrahedra(corners, triangles, 0.2,
                                 progress=lambda stage, *_: stage != "mesh with Gmsh")

    def fail(stage, *_):
        if stage == "mesh with Gmsh":
            raise KeyError(stage)

    with pytest.raises(KeyError):
        octetvdb.fill_tetrahedra(corners, triangles, 0.2, progress=fail)


def test_bad_surfaces_are_refused():
    vertices, triangles = sphere()
    with pytest.raises(octetvdb.InputError, match="not closed"):
        octetvdb.fill_surface(vertices, triangles[1:], 0.4)
    with pytest.raises(octetvdb.InputError):
        octetvdb.fill_surface(vertices, triangles, 10)
    with pytest.raises(octetvdb.InputError):
        octetvdb.fill_surface(vertices, triangles + 10**6, 0.4)
    with pytest.raises(octetvdb.InputError, match="shape"):
        octetvdb.fill_surface(vertices, triangles[:, :2], 0.4)
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.fill_surface(vertices, triangles, 0.2, progress=lambda *report: False)


def test_streamlines_follow_the_field(box):
    refiner = octetvdb.Refiner(box, 1)
    lines = octetvdb.streamlines(refiner.field(2, fluxes(box)), 20)
    assert 3 < len(lines) <= 20
    for line in lines:
        assert line.shape[1] == 3
        across = np.cross(line - line[0], FLOW / np.linalg.norm(FLOW))
        assert np.abs(across).max() < 1e-6
        assert (np.diff(line @ FLOW) > 0).all()
    scalar = refiner.field(0, np.ones(box.complex.vertex_count))
    with pytest.raises(octetvdb.InputError, match="component"):
        octetvdb.streamlines(scalar, 20)
    with pytest.raises(octetvdb.InputError, match="count"):
        octetvdb.streamlines(refiner.field(2, fluxes(box)), 0)


def test_spaced_points_keep_their_distance(box):
    field = octetvdb.Refiner(box, 1).field(2, fluxes(box))
    points = octetvdb.spaced_points(field, 100, 0.2)
    assert 20 < len(points) <= 100 and field.sample(points)[1].all()
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + 9 * np.eye(len(points))
    assert apart.min() >= 0.2
    assert np.array_equal(points, octetvdb.spaced_points(field, 100, 0.2))


def test_pictures_are_the_command_line_s(tmp_path, flow_asset):
    pytest.importorskip("octetvdb._pictures")
    control, vdb = str(tmp_path / "constant.octet.json"), str(tmp_path / "a.vdb")
    flow_asset.write(control)
    octetvdb.bake(flow_asset, vdb, resolution=16)
    for source, given in ((flow_asset, control), (vdb, vdb)):
        for view in ("slice", "3d"):
            mine, theirs = tmp_path / "mine.png", tmp_path / "theirs.png"
            octetvdb.preview(source, str(mine), view=view, width=160, height=90)
            subprocess.run([OCTETVDB, "preview", given, "-o", theirs, "--view", view, "--width",
                            "160", "--height", "90"], check=True, capture_output=True)
            assert mine.read_bytes() == theirs.read_bytes()


def test_bad_pictures_are_refused(tmp_path, flow_asset):
    pytest.importorskip("octetvdb._pictures")
    out = str(tmp_path / "a.png")
    for options, reason in (({"view": "4d"}, "view"), ({"style": "oil"}, "style"),
                            ({"quantity": "age"}, "quantity"), ({"axis": "w"}, "axis"),
                            ({"width": 3}, "width"), ({"form": "none"}, "form"),
                            ({"position": 99.0}, "outside")):
        with pytest.raises(octetvdb.InputError, match=reason):
            octetvdb.preview(flow_asset, out, **options)
    with pytest.raises(octetvdb.InputError):
        octetvdb.preview(str(tmp_path / "missing.vdb"), out)
    with pytest.raises(octetvdb.IoError):
        octetvdb.preview(flow_asset, str(tmp_path / "no" / "a.png"), width=64, height=64)
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.preview(flow_asset, out, progress=lambda *report: False)
    with pytest.raises(TypeError):
        octetvdb.preview(3, out)
    assert os.listdir(tmp_path) == []


def ring(radius=0.5, z=0.0, count=33):
    angles = np.linspace(0, 2 * np.pi, count)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(count, z)], axis=1)


@pytest.fixture(scope="module")
def cube():
    return octetvdb.box_cage([-1, -1, -1], [1, 1, 1], 0.5)


def test_fit_follows_guides_and_keeps_its_promises(cube):
    guides = [octetvdb.GuideCurve("low", ring(z=-0.4)), octetvdb.GuideCurve(
        "high", ring(z=0.4)[::-1], np.full(33, 2.0), weight=2)]
    assert np.array_equal(guides[0].points, ring(z=-0.4)) and guides[1].weight == 2
    fit = octetvdb.Fit(cube)
    result = fit.solve(guides)
    report = result.report
    assert [g.name for g in report.guides] == ["low", "high"] and report.residual < 0.05
    assert not report.conflicts and result.boundary == "walls"
    c = cube.complex
    assert not result.flux[c.boundary_facets].any()
    assert np.abs(c.derivative(2, result.flux)).max() < 1e-13 * np.abs(result.flux).max()
    assert np.allclose(c.derivative(1, result.vector_potential), result.flux, atol=1e-12)
    assert result.circulation is None and result.potential is None
    assert not result.flux.flags.writeable
    values, inside = octetvdb.Refiner(cube, 2).field(2, result.flux, "walls").sample(ring(z=-0.4))
    tangent = np.cross([0, 0, 1], ring(z=-0.4)) / 0.5
    assert inside.all() and np.abs(values - tangent).max() < 0.15
    # Solved again for others; the first result stays.
    before = result.flux.copy()
    fit.solve([octetvdb.GuideCurve("one", ring(0.3))])
    assert np.array_equal(result.flux, before)


def test_fit_of_other_kinds(cube):
    line = np.linspace([-0.8, 0, 0], [0.8, 0, 0], 9)
    guide, vector = octetvdb.GuideCurve("line", line, 1), octetvdb.GuideVector("v", [0, 0.5, 0],
                                                                               [1, 0, 0])
    gradient = octetvdb.Fit(cube, kind="curl-free", closed_walls=False).solve([guide], [vector])
    assert gradient.flux is None and gradient.boundary == "open"
    assert np.allclose(cube.complex.derivative(0, gradient.potential), gradient.circulation)
    free = octetvdb.Fit(cube, kind="free", closed_walls=False).solve([guide], [vector])
    assert free.report.residual < 0.05 and free.vector_potential is None


def test_fit_through_open_facets(cube):
    c, x = cube.complex, cube.vertices
    ends = np.array([f for f in c.boundary_facets if (np.abs(x[c.facets[f], 0]) > 0.99).all()])
    line = np.linspace([-0.9, 0, 0], [0.9, 0, 0], 9)
    guide = octetvdb.GuideCurve("through", line)
    result = octetvdb.Fit(cube, open_facets=ends).solve([guide])
    closed = np.setdiff1d(c.boundary_facets, ends)
    assert not result.flux[closed].any()
    outward = (result.flux * c.outward_signs)[ends]
    assert outward[outward > 0].sum() > 0.1 and abs(outward.sum()) < 1e-12
    assert result.report.residual < octetvdb.Fit(cube).solve([guide]).report.residual
    # Given flux: in at one end, out at the other.
    (first, last) = (next(f for f in ends if x[c.facets[f], 0].mean() * s > 0) for s in (-1, 1))
    given = octetvdb.Fit(cube, flux={int(first): -0.1, int(last): 0.1}).solve([guide])
    assert (given.flux * c.outward_signs)[[first, last]] == pytest.approx([-0.1, 0.1])


def test_bad_fits_are_refused(cube):
    good = octetvdb.GuideCurve("good", ring())
    inner = int(np.flatnonzero(cube.complex.outward_signs == 0)[0])
    for options in ({"kind": "wild"}, {"open_facets": [inner]}, {"open_facets": [10**6]},
                    {"smoothness": -1}, {"flux": {inner: 1.0}}, {"levels": 40},
                    {"kind": "curl-free", "open_facets": [0]}):
        with pytest.raises(octetvdb.InputError):
            octetvdb.Fit(cube, **options)
    fit = octetvdb.Fit(cube)
    with pytest.raises(octetvdb.InputError, match="none"):
        fit.solve([])
    with pytest.raises(octetvdb.InputError, match="far.*outside"):
        fit.solve([good, octetvdb.GuideCurve("far", ring(3.0))])
    with pytest.raises(octetvdb.InputError, match="dot"):
        fit.solve([octetvdb.GuideCurve("dot", np.zeros((2, 3)))])
    with pytest.raises(octetvdb.InputError):
        octetvdb.GuideCurve("short", ring(), [1.0, 2.0])
    with pytest.raises(octetvdb.InputError):
        octetvdb.GuideCurve("nan", ring() * np.nan)
    with pytest.raises(octetvdb.InputError):
        octetvdb.GuideVector("flat", [0, 0], [1, 0, 0])
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.Fit(cube, progress=lambda *report: False)


def test_fit_cancels_while_it_solves(cube):
    calls = [0]
    stop_at = [10**9]

    def progress(*report):
        calls[0] += 1
        return calls[0] < stop_at[0]
    fit = octetvdb.Fit(cube, progress=progress)
    made = calls[0]
    fit.solve([octetvdb.GuideCurve("good", ring())])
    assert calls[0] == made  # the constructor's callback is not kept
    fit.solve([octetvdb.GuideCurve("good", ring())], progress=progress)
    assert calls[0] > made
    stop_at[0] = 0
    with pytest.raises(octetvdb.Cancelled):
        fit.solve([octetvdb.GuideCurve("good", ring())], progress=progress)


def test_primitives_are_their_fields(cube):
    c = cube.complex
    p, q, r = (cube.vertices[c.facets[:, k]] for k in range(3))
    area, centre = np.cross(q - p, r - p) / 2, (p + q + r) / 3
    along = cube.vertices[c.edges[:, 1]] - cube.vertices[c.edges[:, 0]]
    middle = cube.vertices[c.edges].mean(axis=1)
    for primitive, field in (
            (octetvdb.UniformFlow([1, 2, 3]), lambda x: np.broadcast_to([1.0, 2, 3], x.shape)),
            (octetvdb.RigidRotation([0.1, 0.2, 0.3], [0, 0, 2]),
             lambda x: np.cross([0, 0, 2], x - [0.1, 0.2, 0.3]))):
        flux = octetvdb.integrate(primitive, cube)
        # Of a linear field the middle's value is the mean.
        assert np.allclose(flux, np.einsum("ij,ij->i", field(centre), area), atol=1e-13)
        assert np.abs(c.derivative(2, flux)).max() < 1e-13
        circulation = octetvdb.integrate(primitive, cube, 1)
        assert np.allclose(circulation, np.einsum("ij,ij->i", field(middle), along), atol=1e-13)
    source = octetvdb.integrate(octetvdb.PointSource([0.1, 0.05, -0.03], 2.5), cube)
    assert c.derivative(2, source).sum() == pytest.approx(2.5)
    for primitive in (octetvdb.VortexLine([0, 0.1, 0], [0, 0, 1], 1.0, 0.1),
                      octetvdb.VortexRing([0, 0, 0], [0, 0, 1], 0.5, 1.0, 0.1),
                      octetvdb.CurlNoise(1.0, 1.0, 0.5, seed=3, waves=16)):
        flux = octetvdb.integrate(primitive, cube)
        assert np.abs(c.derivative(2, flux)).max() < 1e-10 * np.abs(flux).max()
        closed = octetvdb.nearest_closed(cube, 2, flux, c.boundary_facets)
        assert not closed[c.boundary_facets].any() and np.abs(closed).max() > 0
        assert np.abs(c.derivative(2, closed)).max() < 1e-12 * np.abs(flux).max()
    same = octetvdb.integrate(octetvdb.CurlNoise(1.0, 1.0, 0.5, seed=3, waves=16), cube)
    other = octetvdb.integrate(octetvdb.CurlNoise(1.0, 1.0, 0.5, seed=4, waves=16), cube)
    assert np.array_equal(same, flux) and not np.array_equal(other, flux)


def test_bad_primitives_are_refused(cube):
    for make in (lambda: octetvdb.UniformFlow([1, 2]), lambda: octetvdb.UniformFlow([np.nan, 0, 0]),
                 lambda: octetvdb.VortexLine([0, 0, 0], [0, 0, 0], 1.0),
                 lambda: octetvdb.VortexRing([0, 0, 0], [0, 0, 1], -1.0, 1.0),
                 lambda: octetvdb.PointSource([0, 0, 0], 1.0, -1.0),
                 lambda: octetvdb.CurlNoise(1.0, 0.0, 0.5),
                 lambda: octetvdb.integrate(octetvdb.UniformFlow([1, 0, 0]), cube, 3),
                 lambda: octetvdb.nearest_closed(cube, 0, np.zeros(cube.complex.vertex_count)),
                 lambda: octetvdb.nearest_closed(cube, 2, np.zeros(cube.complex.facet_count), [10**6])):
        with pytest.raises(octetvdb.InputError):
            make()
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.integrate(octetvdb.CurlNoise(1.0, 1.0, 0.5), cube, progress=lambda *report: False)
    with pytest.raises(TypeError):
        octetvdb.integrate("wind", cube)


def test_corrections_bring_a_sampled_flow_nearer(tmp_path, cube):
    asset = octetvdb.ControlAsset(cube, [octetvdb.Form(cube, "vortex", 2, octetvdb.integrate(
        octetvdb.VortexRing([0, 0, 0], [0, 0, 1], 0.5, 1.0, 0.2), cube))])
    path = str(tmp_path / "vortex.vdb")
    octetvdb.bake(asset, path, voxel_size=0.05)
    empty = octetvdb.ControlAsset(octetvdb.box_cage([-0.8] * 3, [0.8] * 3, 0.4), name="small")
    errors = [octetvdb.sample_velocity(empty, [path], corrections=n)[1][0].error for n in (0, 3)]
    assert errors[1] < 0.8 * errors[0]
    for corrections in (-1, 21):
        with pytest.raises(octetvdb.InputError, match="corrections"):
            octetvdb.sample_velocity(empty, [path], corrections=corrections)


def test_sampling_a_baked_flow_gives_it_back(tmp_path, cube):
    flux = octetvdb.integrate(octetvdb.UniformFlow([1, 2, 3]), cube)
    asset = octetvdb.ControlAsset(cube, [octetvdb.Form(cube, "wind", 2, flux)])
    path = str(tmp_path / "wind.vdb")
    octetvdb.bake(asset, path, voxel_size=0.05, boundary="open")
    small = octetvdb.box_cage([-0.5] * 3, [0.5] * 3, 0.25)
    empty = octetvdb.ControlAsset(small, name="small")
    sampled, (frame,) = octetvdb.sample_velocity(empty, [path], name="found", closed=True)
    assert [f.name for f in sampled.forms] == ["found"] and not empty.forms
    expected = octetvdb.integrate(octetvdb.UniformFlow([1, 2, 3]), small)
    assert np.allclose(sampled.form("found").coefficients(), expected, atol=1e-6)
    assert frame.grid == "wind" and frame.after < 1e-12 and frame.error < 1e-3
    per_frame, _ = octetvdb.sample_velocity(empty, [path], velocity_unit="units/frame")
    assert np.allclose(per_frame.form("velocity").coefficients(), 24 * expected, atol=1e-4)
    for options in ({"degree": 0}, {"boundary_flux": "leaky"}, {"velocity_unit": "knots"},
                    {"grid": "smoke"}):
        with pytest.raises(octetvdb.InputError):
            octetvdb.sample_velocity(empty, [path], **options)
    with pytest.raises(octetvdb.InputError):
        octetvdb.sample_velocity(empty, [str(tmp_path / "missing.vdb")])
    with pytest.raises(octetvdb.InputError):
        octetvdb.sample_velocity(empty, [])
    with pytest.raises(octetvdb.Cancelled):
        octetvdb.sample_velocity(empty, [path], progress=lambda *report: False)
