#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The data sets of the thesis, as far as its captions tell them.

M_E (Fig. 2.10): the 1-ring of a regular vertex. M_X: the same with one side pushed in until it is
concave. M_I (Fig. 4.13): a lattice with one edge and one facet nonzero. M_B (Fig. 5.2): nonzero
coefficients in the interior and on the boundary.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

HERE = os.path.dirname(os.path.abspath(__file__))


def one_ring():
    """14 cells around the origin: the lattice cells that have it as a vertex."""
    whole = oa.lattice(lambda p: max(map(abs, p)) <= 2, 2)
    origin = whole.vertices.index((0.0, 0.0, 0.0))
    tetrahedra = [t for t in whole.tetrahedra if origin in t]
    octahedra = [o for o in whole.octahedra if origin in o]
    used = sorted({v for c in tetrahedra + octahedra for v in c})
    new = {v: k for k, v in enumerate(used)}
    return oa.Cage([whole.vertices[v] for v in used],
                   [[new[v] for v in t] for t in tetrahedra],
                   [[new[v] for v in o] for o in octahedra], creases=[])


def turning(p):
    """Turns around a tilted axis and rises along it."""
    return (-p[1] + 0.3, p[0] - 0.2 * p[2], 0.5 + 0.2 * p[1])


def flow_forms(cage):
    circulation = {e: cage.circulation(turning, e) for e in cage.edges}
    flux = {f: cage.flux(turning, f) for f in cage.facets}
    return [oa.form("circulation", 1, "m^2/s", circulation), oa.form("flux", 2, "m^3/s", flux)]


def make_m_e():
    cage = one_ring()
    oa.write(os.path.join(HERE, "M_E.octet.json"), "M_E", cage, flow_forms(cage))


def make_m_x():
    cage = one_ring()
    # The far vertex in x comes in past the plane x = 1 of its neighbours: a concave octahedron. Its
    # centroid, where it is split, stays inside as long as this vertex is beyond 0.8.
    cage.vertices = [(0.9, y, z) if x == 2 else (x, y, z) for x, y, z in cage.vertices]
    oa.write(os.path.join(HERE, "M_X.octet.json"), "M_X", cage, flow_forms(cage))


def make_m_i():
    cage = oa.lattice(lambda p: sum(map(abs, p)) <= 4, 4, creases=[])
    at = {tuple(map(int, p)): v for v, p in enumerate(cage.vertices)}
    edge = (at[0, 0, 0], at[1, 1, 0])
    facet = (at[0, 0, 0], at[1, 1, 0], at[1, 0, 1])
    oa.write(os.path.join(HERE, "M_I.octet.json"), "M_I", cage,
             [oa.form("one_edge", 1, "m^2/s", {edge: 1.0}),
              oa.form("one_facet", 2, "m^3/s", {facet: 1.0})])


def make_m_b():
    cage = oa.lattice(lambda p: sum(map(abs, p)) <= 4, 4, creases=[])
    near = [v for v, p in enumerate(cage.vertices) if p[0] >= 0 and abs(p[1]) + abs(p[2]) <= 2]
    circulation = {e: cage.circulation(turning, e) for e in cage.edges
                   if e[0] in near and e[1] in near}
    flux = {f: cage.flux(turning, f) for f in cage.facets if all(v in near for v in f)}
    oa.write(os.path.join(HERE, "M_B.octet.json"), "M_B", cage,
             [oa.form("circulation", 1, "m^2/s", circulation),
              oa.form("flux", 2, "m^3/s", flux)])


if __name__ == "__main__":
    make_m_e()
    make_m_x()
    make_m_i()
    make_m_b()
