#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hill's spherical vortex with swirl, sampled on the edges of a ball that Gmsh meshed.

The flow rises along the axis and returns along the surface, which it never crosses, and turns around
the axis, so that streamlines wind around tori. Its vector potential is 0 on the sphere, so that
boundary edges, chords of the sphere, get exactly 0. Only this script needs Gmsh (python3-gmsh); the
asset it writes holds the mesh.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import octet_asset as oa

PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ball.octet.json")
EDGE_LENGTH = 0.28  # asked of Gmsh; the ball has radius 1
TETRAHEDRON = 4  # Gmsh's element type
SPEED = 1.0  # at the centre
SWIRL = 0.6  # angular


def potential(p):
    """Its curl is SPEED (x z, y z, 1 - 2 (x^2 + y^2) - z^2) + SWIRL (-y, x, 0)."""
    x, y, z = p
    bump = (1 - x * x - y * y - z * z) / 2
    return (-SPEED * bump * y, SPEED * bump * x, SWIRL * bump)


def mesh_ball():
    """Vertices and tetrahedra from Gmsh, on one thread and from its default seed."""
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.model.occ.addSphere(0, 0, 0, 1)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", EDGE_LENGTH)
    gmsh.option.setNumber("Mesh.MeshSizeMax", EDGE_LENGTH)
    gmsh.model.mesh.generate(3)
    tags, points, _ = gmsh.model.mesh.getNodes()
    position = {tag: tuple(points[3 * k:3 * k + 3]) for k, tag in enumerate(tags)}
    _, corners = gmsh.model.mesh.getElementsByType(TETRAHEDRON)
    gmsh.finalize()
    used = sorted(set(corners))
    number = {tag: k for k, tag in enumerate(used)}
    tetrahedra = [tuple(number[tag] for tag in corners[k:k + 4])
                  for k in range(0, len(corners), 4)]
    return [position[tag] for tag in used], tetrahedra


def write(path, vertices, tetrahedra):
    # The sphere is smooth: no creases, however sharp the coarse mesh's edges are.
    cage = oa.Cage(vertices, tetrahedra, creases=[])
    circulation = {e: 0.0 if e in cage.boundary_edges else cage.circulation(potential, e)
                   for e in cage.edges}
    velocity = {(a, b, c): circulation[a, b] + circulation[b, c] - circulation[a, c]
                for a, b, c in cage.facets}
    oa.write(path, "ball", cage, [oa.form("velocity", 2, "m^3/s", velocity),
                                  oa.form("potential", 1, "m^2/s", circulation)])


def main():
    write(PATH, *mesh_ball())


if __name__ == "__main__":
    main()
