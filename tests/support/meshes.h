// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <octet/core/topology/control_mesh.h>

/// @file
/// Meshes for tests, made by code, the same on every machine.

namespace octet::testing {

/// A mesh with the name it has in test output.
struct NamedMesh {
  std::string name;
  ControlMeshInput input;
};

ControlMeshInput singleTetrahedron();
/// Convex, or with one ring vertex pushed in past the axis.
ControlMeshInput singleOctahedron(bool concave = false);
/// n tetrahedra around one edge.
ControlMeshInput tetrahedraAroundEdge(int n);
/// A box of n^3 cubes, six tetrahedra each, inner vertices moved at random, edges creased.
ControlMeshInput creasedBox(int n, double jitter, std::uint32_t seed);
/// Delaunay tetrahedra of random points in a ball, about three points' spacing across `n` of them.
ControlMeshInput randomBall(int points, std::uint32_t seed);
/// The same with every set of four tetrahedra around an edge that can be made an octahedron so
/// made.
ControlMeshInput withOctahedra(ControlMeshInput tets);
/// Lattice cells whose vertices all satisfy `inside`; positions moved at random by `jitter`.
ControlMeshInput latticeBlock(const std::function<bool(int, int, int)>& inside, int radius,
                              double jitter = 0, std::uint32_t seed = 0);
/// The 1-ring of a regular vertex, the thesis' M_E.
ControlMeshInput regularOneRing();
/// Cells dropped at random: any boundary, touching itself too.
ControlMeshInput withHoles(ControlMeshInput mesh, double fraction, std::uint32_t seed);
/// The mesh with its vertices, cells and the vertices of each cell in another order.
ControlMeshInput shuffled(const ControlMeshInput& mesh, std::uint32_t seed);

/// What GoogleTest prints of a mesh.
inline void PrintTo(const NamedMesh& mesh, std::ostream* os) { *os << mesh.name; }

/// One of each kind that tests should hold on, a few to several hundred cells.
std::vector<NamedMesh> allKinds();
/// Randomly generated meshes of several hundred cells, smooth boundaries (no creases).
std::vector<NamedMesh> randomMeshes();

/// Random coefficients in [-1, 1], one per simplex.
std::vector<double> randomValues(Index count, std::uint32_t seed);

}  // namespace octet::testing
