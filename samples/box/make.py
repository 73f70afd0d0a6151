#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A closed, creased box with two stacked vortices that turn against each other.

The flow is the curl of a vector potential that has no tangential part on the walls, so that nothing
crosses them: every boundary coefficient of `velocity` is exactly 0, and stays 0 at every level.
Both the potential (1-form) and the velocity (2-form, the potential's derivative) are stored.
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

SIZE = (2.0, 2.0, 3.0)


def potential(p):
    """Vanishes tangentially on the walls: each component on the four walls parallel to it."""
    x, y, z = (math.pi * (p[k] / SIZE[k] + 0.5) for k in range(3))
    return (0.35 * math.sin(y) * math.sin(2 * z), 0.25 * math.sin(x) * math.sin(z),
            0.6 * math.sin(x) * math.sin(y) * math.cos(z))


def main():
    cage = oa.box((4, 4, 6), SIZE)
    circulation = {e: 0.0 if e in cage.boundary_edges else cage.circulation(potential, e)
                   for e in cage.edges}

    def flux(facet):
        a, b, c = facet
        return circulation[a, b] + circulation[b, c] - circulation[a, c]

    velocity = {f: 0.0 if f in cage.boundary_facets else flux(f) for f in cage.facets}
    out = os.path.join(os.path.dirname(os.path.abspath(__file__)), "box.octet.json")
    oa.write(out, "box", cage,
             [oa.form("velocity", 2, "m^3/s", velocity),
              oa.form("potential", 1, "m^2/s", circulation)])


if __name__ == "__main__":
    main()
