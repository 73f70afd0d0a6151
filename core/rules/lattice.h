// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cell_tables.h"

/// @file
/// The face-centred cubic lattice and its octet mesh (thesis 2.1.2, Figs 2.5-2.8): integer points
/// of even coordinate sum, tetrahedra in the unit cubes, octahedra around the odd points. All
/// simplices of one kind fall into translation classes: 1 of vertices, 6 of edges, 8 of facets and
/// 3 of cells (two tetrahedra, one octahedron).

namespace octet {

using Int3 = std::array<int, 3>;

inline constexpr int kEdgeClasses = 6, kFacetClasses = 8, kCellClasses = 3;

/// The points that smoothing averages over (SCHEME.md section 5): the point itself (last), its 12
/// neighbours and the 6 second neighbours across an octahedron.
inline constexpr int kNeighbours = 18, kSelf = 18;

/// Weight of neighbour k in the smoothing average: 1/16, 1/48 and, for kSelf, 1/8.
constexpr double translateWeight(int k) { return k < 12 ? 1.0 / 16 : k < 18 ? 1.0 / 48 : 1.0 / 8; }

/// A simplex of the lattice relative to a cell that has it: the local vertex that is its base (the
/// lexicographically least), its class, and whether the local order keeps the class' orientation
/// (vertices in lexicographic order).
struct LatticeSlot {
  std::uint8_t base, simplexClass;
  std::int8_t sign;
};

/// How a cell of given shape lies in the lattice under one of the 48 symmetries.
template <typename Shape>
struct CellPlacement {
  /// Which neighbour of local vertex i local vertex j is.
  std::uint8_t neighbour[Shape::kVertices][Shape::kVertices];
  LatticeSlot edges[Shape::kEdges];    ///< local order: lower to higher vertex
  LatticeSlot facets[Shape::kFacets];  ///< local order: outward triple
  LatticeSlot cell;                    ///< sign: orientation of the placed cell in the lattice
};

/// One term of a lattice chain: the simplex of class `simplexClass` based at the point reached from
/// the chain's own base by two hops to neighbours.
struct LatticeTerm {
  std::uint8_t hops[2];
  std::uint8_t simplexClass;
  bool certain;  ///< lies in the closed star of the target's vertices, so it exists around R
                 ///< vertices
  double weight;
};

/// @brief Tables of the lattice, computed once from its geometry.
///
/// `edgeHomotopy` and `facetHomotopy` are the rows of D2 and D3 (SCHEME.md section 6) that make
/// M1 and M2 the average over translates: for an edge the 2-chain of least norm to its average, for
/// a facet the unique 3-chain. They are needed only next to irregular simplices, where the complex
/// stays exact because both sides use the same chains.
struct Lattice {
  static const Lattice& get();

  std::array<Int3, kNeighbours + 1> neighbours;
  std::array<Int3, kEdgeClasses> edges;                   ///< from the base
  std::array<std::array<Int3, 2>, kFacetClasses> facets;  ///< from the base, in order
  std::array<std::vector<LatticeTerm>, kEdgeClasses> edgeHomotopy;
  std::array<std::vector<LatticeTerm>, kFacetClasses> facetHomotopy;

  /// Where the vertices of a simplex class are, as neighbours of the base (base excluded).
  std::array<std::uint8_t, kEdgeClasses> edgeEnd;
  std::array<std::array<std::uint8_t, 2>, kFacetClasses> facetEnds;
  std::array<std::array<std::uint8_t, 5>, kCellClasses> cellEnds;
  std::array<std::uint8_t, kCellClasses> cellEndCount;
  /// The simplices on a class' boundary, based at the point reached by `hops[0]`.
  std::array<std::array<LatticeTerm, 3>, kFacetClasses> facetBoundary;
  std::array<std::vector<LatticeTerm>, kCellClasses> cellBoundary;

  std::array<CellPlacement<Tetrahedron>, 48> tetPlacements;
  std::array<CellPlacement<Octahedron>, 48> octPlacements;

  /// Symmetry `frame` applied to a vector.
  Int3 rotate(int frame, const Int3& v) const;
  /// The symmetry "first `inner`, then `outer`".
  int compose(int outer, int inner) const { return products[outer][inner]; }
  /// Frame of a child cell within its parent's frame. Corner children keep their parent's.
  int tetToOct;                          ///< the octahedron in a tetrahedron
  std::array<std::uint8_t, 8> octToTet;  ///< the tetrahedron under facet f of an octahedron

  /// The frame, and the place of the lattice point that local vertex 0 gets, for which three local
  /// vertices come to lie at given points; false when there is none.
  template <typename Shape>
  bool place(const std::array<int, 3>& local, const std::array<Int3, 3>& at, int* frame,
             std::array<Int3, Shape::kVertices>* points) const;

  std::array<std::array<std::uint8_t, 48>, 48> products;

 private:
  Lattice();
};

/// Lattice points of the cell with the identity frame.
template <typename Shape>
const std::array<Int3, Shape::kVertices>& canonicalPoints();

/// The FCC neighbourhood as a mesh: cells around the origin, for tests and for deriving masks.
/// Every tetrahedron and octahedron that has a vertex in the box |x|,|y|,|z| <= radius.
struct LatticePatch {
  explicit LatticePatch(int radius);
  std::vector<Int3> points;
  std::vector<std::array<std::int32_t, 4>> tets;
  std::vector<std::array<std::int32_t, 6>> octs;
};

}  // namespace octet
