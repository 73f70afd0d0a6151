# SPDX-License-Identifier: Apache-2.0
"""Control assets from and to meshio meshes, and so from and to the formats that meshio knows.

No format has octahedra: one is written as the two pyramids over its ring. Coefficients are cell data
on the simplices they belong to: lines (1-forms), triangles (2-forms), tetrahedra and pyramids
(3-forms), not a number elsewhere; and point data (0-forms).
"""
from __future__ import annotations

import numpy as np

from ._octetvdb import ControlAsset, ControlMesh, Form, InputError

_DEGREE_OF_BLOCK = {"line": 1, "triangle": 2, "tetra": 3, "pyramid": 3}


def to_meshio(asset, frame=0):
    """A meshio.Mesh of a control asset, with its forms as of one frame.

    Points are the vertices (world units). Blocks are "tetra", "pyramid" (two for each octahedron,
    with half its 3-form each), and as far as forms and creases need them "line" and "triangle".
    Sharp edges are the cell set "creases", corners the point set "corners". Needs meshio.
    """
    import meshio

    mesh = asset.mesh
    complex_ = mesh.complex
    dense = {form: form.coefficients(frame) for form in asset.forms}
    blocks = {}
    creases = _index_of(mesh.edge_index, mesh.creases)[0]
    edges = _listed(dense, 1, [creases])
    if len(edges):
        blocks["line"] = complex_.edges[edges]
    facets = _listed(dense, 2, [])
    if len(facets):
        blocks["triangle"] = complex_.facets[facets]
    if len(mesh.tetrahedra):
        blocks["tetra"] = mesh.tetrahedra
    if len(mesh.octahedra):
        blocks["pyramid"] = _pyramids(mesh)

    tets = len(mesh.tetrahedra)
    point_data, cell_data = {}, {}
    for form, values in dense.items():
        if form.degree == 0:
            point_data[form.name] = values
            continue
        on = {name: np.full(len(cells), np.nan) for name, cells in blocks.items()}
        if form.degree == 1 and "line" in on:
            on["line"] = values[edges]
        if form.degree == 2 and "triangle" in on:
            on["triangle"] = values[facets]
        if form.degree == 3 and "tetra" in on:
            on["tetra"] = values[:tets]
        if form.degree == 3 and "pyramid" in on:
            on["pyramid"] = np.repeat(values[tets:] / 2, 2)
        cell_data[form.name] = list(on.values())
    sharp = [np.flatnonzero(np.isin(edges, creases)) if name == "line" else np.array([], int)
             for name in blocks]
    return meshio.Mesh(mesh.vertices.copy(), list(blocks.items()), point_data=point_data,
                       cell_data=cell_data, cell_sets={"creases": sharp},
                       point_sets={"corners": mesh.corners.copy()})


def from_meshio(mesh, *, name="", up_axis="Z", meters_per_unit=1.0, frames_per_second=24.0):
    """A ControlAsset from a meshio.Mesh.

    Takes "tetra" blocks, and "pyramid" blocks whose pyramids share their squares in pairs. Points of
    no cell are dropped. Each scalar array of floats becomes a form: point data a 0-form, cell data
    the form of the blocks on which it has numbers; what is not a number, and simplices of no block,
    count as 0. Lines and triangles are oriented by the order of their points. Other data is left
    out. A cell set "creases" on lines and a point set "corners" replace the guess of sharp edges.

    Raises InputError: no such cells, a pyramid without its partner, data on blocks of several
    kinds, lines that are no edge; and what ControlMesh raises.
    """
    by_type = {kind: [] for kind in _DEGREE_OF_BLOCK}
    for k, block in enumerate(mesh.cells):
        if block.type in by_type:
            by_type[block.type].append((k, np.asarray(block.data, np.int64).reshape(
                len(block.data), -1)))
    tetrahedra = _stack(by_type["tetra"], 4)
    octahedra, octahedron_of = _octahedra(_stack(by_type["pyramid"], 5))
    cell_numbers = {"tetra": np.arange(len(tetrahedra)),
                    "pyramid": len(tetrahedra) + octahedron_of}
    used = np.unique(np.concatenate([tetrahedra.ravel(), octahedra.ravel()]))
    if not len(used):
        raise _input_error("the mesh has no tetrahedra and no pyramids")
    points = np.asarray(mesh.points, float)
    if used[0] < 0 or used[-1] >= len(points):
        raise _input_error("a cell's point is out of range")
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))

    creases = corners = None
    if "creases" in mesh.cell_sets:
        sharp = [block[np.asarray(mesh.cell_sets["creases"][k], int)]
                 for k, block in by_type["line"]]
        creases = number[np.concatenate(sharp)] if sharp else np.empty((0, 2), int)
    if "corners" in mesh.point_sets:
        corners = number[np.asarray(mesh.point_sets["corners"], int)]
        corners = corners[corners >= 0]
    control = ControlMesh(points[used], number[tetrahedra], number[octahedra],
                          creases=creases, corners=corners)
    forms = [Form(control, key, 0, np.nan_to_num(np.asarray(values, float)[used]))
             for key, values in mesh.point_data.items() if _is_scalar(key, values)]
    for key, values in mesh.cell_data.items():
        if all(_is_scalar(key, v) for v in values):
            form = _form_of_cell_data(control, key, values, by_type, number, cell_numbers)
            if form is not None:
                forms.append(form)
    return ControlAsset(control, forms, name=name, up_axis=up_axis,
                        meters_per_unit=meters_per_unit, frames_per_second=frames_per_second)


def _index_of(find, rows):
    return find(rows) if len(rows) else (np.empty(0, int), np.empty(0, int))


def _input_error(reason):
    error = InputError(reason)
    error.reason = reason
    return error


def _listed(dense, degree, more):
    """Indices of the simplices on which forms of a degree are not 0, and more of them."""
    lists = [np.flatnonzero(v) for form, v in dense.items() if form.degree == degree] + more
    return np.unique(np.concatenate(lists).astype(int)) if lists else np.empty(0, int)


def _pyramids(mesh):
    """(ring, first pole) and (ring the other way round, last pole), with positive volume."""
    o, x = mesh.octahedra.astype(int), mesh.vertices
    axis = x[o[:, 0]] - x[o[:, 5]]
    outward = np.cross(x[o[:, 3]] - x[o[:, 1]], x[o[:, 4]] - x[o[:, 2]])
    up = np.einsum("ij,ij->i", axis, outward) > 0
    ring = np.where(up[:, None], o[:, [1, 2, 3, 4]], o[:, [1, 4, 3, 2]])
    pairs = np.stack([np.column_stack([ring, o[:, 0]]),
                      np.column_stack([ring[:, [0, 3, 2, 1]], o[:, 5]])], axis=1)
    return pairs.reshape(-1, 5)


def _stack(found, columns):
    return np.concatenate([block for _, block in found]) if found else np.empty((0, columns), int)


def _octahedra(pyramids):
    """Octahedra (n, 6) of pyramids that share their squares in pairs, in the order of the first of
    each pair; and for each pyramid its octahedron."""
    where = {}
    octahedra, owner = [], []
    for a, b, c, d, apex in pyramids.tolist():
        square = frozenset([frozenset([a, c]), frozenset([b, d])])
        k = where.setdefault(square, len(octahedra))
        owner.append(k)
        if k == len(octahedra):
            octahedra.append([apex, a, b, c, d])
        else:
            octahedra[k].append(apex)
    for k, octahedron in enumerate(octahedra):
        if len(octahedron) != 6:
            sharers = "no other" if len(octahedron) == 5 else "more than one other"
            raise _input_error(f"pyramid {owner.index(k)} shares its square with {sharers}")
    return np.array(octahedra, int).reshape(-1, 6), np.array(owner, int)


def _is_scalar(key, values):
    """Floats, one each; names such as "gmsh:physical" are tags of a file format."""
    values = np.asarray(values)
    return values.ndim == 1 and values.dtype.kind == "f" and ":" not in key


def _form_of_cell_data(control, key, values, by_type, number, cell_numbers):
    """The form whose simplices have numbers; None when there are none."""
    found = {}
    for kind, blocks in by_type.items():
        for k, block in blocks:
            given = np.asarray(values[k], float)
            if np.isfinite(given).any():
                found.setdefault(_DEGREE_OF_BLOCK[kind], []).append((kind, block, given))
    if not found:
        return None
    if len(found) > 1:
        raise _input_error(f'data "{key}" has numbers on cells of several dimensions')
    (degree, parts), = found.items()
    dense = np.zeros(control.complex.count(degree))
    if degree == 3:
        for kind in {kind for kind, _, _ in parts}:
            whole = np.concatenate([np.asarray(values[k], float) for k, _ in by_type[kind]])
            np.add.at(dense, cell_numbers[kind], np.nan_to_num(whole))
        return Form(control, key, 3, dense)
    find = control.edge_index if degree == 1 else control.facet_index
    for _, block, given in parts:
        keep = np.isfinite(given)
        index, sign = find(number[block[keep]])
        dense[index] += sign * given[keep]
    return Form(control, key, degree, dense)
