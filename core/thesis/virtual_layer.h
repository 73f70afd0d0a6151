// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "../rules/lattice.h"
#include "../topology/control_mesh.h"

namespace octet {

/// A chain of simplices of a mesh, or a combination of its vertices: index and weight.
using SparseChain = std::vector<std::pair<Index, double>>;

/// @brief A control mesh with one virtual layer of cells around it, so that every vertex of the
/// mesh is an interior one (thesis 5.4, Algorithm 1 and Figs 5.8 to 5.13).
///
/// Virtual vertices are affine combinations of the mesh's. Real vertices and cells keep their
/// numbers, virtual ones follow: tetrahedra after tetrahedra, octahedra after octahedra.
///
/// A mesh that is one lattice region is continued as the lattice, also at its edges and corners:
/// a virtual vertex is the combination of least norm of the real ones around it that is right for
/// affine maps of the lattice. Beside an octahedron's facet that is the thesis' 2/3 (v1 + v2 + v3)
/// - 1/3 (V1 + V2 + V3). On a lattice block the layer is thus exact.
///
/// What the thesis did at edges and corners of other meshes is lost. Here: a boundary facet gets
/// an octahedron if it belongs to a tetrahedron, else a tetrahedron, made from parallelograms of
/// its own cell. Across a boundary edge neighbours share the virtual vertex there, unless the edge
/// has one cell only or both have a tetrahedron outside; then a cell goes between them. What is
/// still open around a boundary vertex is closed by a tetrahedron, an octahedron, or tetrahedra
/// around one more virtual vertex. This closes every star; at reflex edges it is not the lattice's.
struct VirtualLayer {
  /// @throws InputError where cells that touch leave no room to tell the layer's facets apart
  explicit VirtualLayer(const ControlMesh& mesh);

  ControlMeshInput expanded;          ///< no creases, no corners, cell signs given
  std::vector<SparseChain> vertices;  ///< each virtual vertex, as combination
  std::vector<Int3> sites;            ///< lattice sites of all vertices; empty if none
  std::map<Int3, Index> atSite;       ///< and back
};

}  // namespace octet
