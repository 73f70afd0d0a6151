#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A ball cut from the regular lattice of tetrahedra and octahedra, with all four degrees of form.

Away from its boundary every vertex is regular, and the flow is exactly the thesis' smooth scheme.
`velocity` is an ABC flow (divergence-free), `force` the gradient of `height`, `smoke` the density of
a puff that ends inside.
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

RADIUS = 4
PUFF_RADIUS = 2.5


def abc(p):
    """An ABC flow is its own curl, so it serves as its own vector potential."""
    x, y, z = (0.6 * c for c in p)
    return (math.sin(z) + 0.7 * math.cos(y), 0.8 * math.sin(x) + math.cos(z),
            0.7 * math.sin(y) + 0.8 * math.cos(x))


def height(p):
    return p[2] + 0.1 * p[0] * p[0]


def puff(p):
    return max(0.0, 1 - sum(c * c for c in p) / PUFF_RADIUS ** 2) ** 2


def main():
    cage = oa.lattice(lambda p: sum(c * c for c in p) <= RADIUS ** 2, RADIUS, creases=[])
    # curl abc = 0.6 abc, so the flux of abc is its circulation over 0.6.
    velocity = {f: cage.curl_flux(abc, f) / 0.6 for f in cage.facets}
    heights = {(v,): height(p) for v, p in enumerate(cage.vertices)}
    force = {e: heights[(e[1],)] - heights[(e[0],)] for e in cage.edges}
    cells = [(t, 1 / 3) for t in cage.tetrahedra] + [(o, 4 / 3) for o in cage.octahedra]
    smoke = {}
    for cell, volume in cells:
        centre = [sum(cage.vertices[v][k] for v in cell) / len(cell) for k in range(3)]
        smoke[tuple(cell)] = volume * puff(centre)
    out = os.path.join(os.path.dirname(os.path.abspath(__file__)), "lattice.octet.json")
    oa.write(out, "lattice", cage,
             [oa.form("velocity", 2, "m^3/s", velocity), oa.form("force", 1, "m^2/s^2", force),
              oa.form("height", 0, "m", heights), oa.form("smoke", 3, "kg", smoke)])


if __name__ == "__main__":
    main()
