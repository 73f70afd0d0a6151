#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A vortex that circles in a closed tank, 24 frames: every frame a closed 2-form with no wall flux.

Topology and positions do not change, so the bake refines them once for all frames.
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

SIZE = (2.0, 2.0, 1.0)
FRAMES = 24


def potential(frame):
    """A vertical vortex around a centre that goes round once, damped to nothing at the walls."""
    turn = 2 * math.pi * (frame - 1) / FRAMES
    centre = (0.4 * math.cos(turn), 0.4 * math.sin(turn))

    def field(p):
        walls = math.prod(math.cos(math.pi * p[k] / SIZE[k]) for k in range(2))
        near = math.exp(-((p[0] - centre[0]) ** 2 + (p[1] - centre[1]) ** 2) / 0.3)
        return (0.0, 0.0, walls * near)

    return field


def main():
    cage = oa.box((4, 4, 2), SIZE)
    velocity = {f: {} for f in cage.facets if f not in cage.boundary_facets}
    for frame in range(1, FRAMES + 1):
        field = potential(frame)
        circulation = {e: 0.0 if e in cage.boundary_edges else cage.circulation(field, e)
                       for e in cage.edges}
        for a, b, c in velocity:
            velocity[a, b, c][frame] = circulation[a, b] + circulation[b, c] - circulation[a, c]
    moving = {f: v for f, v in velocity.items() if any(v.values())}
    out = os.path.join(os.path.dirname(os.path.abspath(__file__)), "animated.octet.json")
    oa.write(out, "animated", cage, [oa.form("velocity", 2, "m^3/s", moving)])


if __name__ == "__main__":
    main()
