// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "../base/context.h"
#include "complex.h"

namespace octet {

/// What a control mesh is made from; indices count from 0.
struct ControlMeshInput {
  Array<Vec3> vertices;              ///< world units
  Array<std::array<Index, 4>> tets;  ///< any orientation
  Array<std::array<Index, 6>> octs;  ///< (pole; ring of four; pole), any orientation
  /// Sharp boundary edges. Absent: those whose dihedral angle is more than 40 degrees from flat, or
  /// that have more than two boundary facets.
  std::optional<std::vector<std::array<Index, 2>>> creases;
  std::vector<Index> corners;  ///< boundary vertices that stay, beside those where creases end
  /// Lattice region and frame of each cell, tetrahedra first, where the mesh is a piece of one that
  /// knows them (Complex::cellRegions, cellFrames); empty: found from the cells.
  std::vector<Index> cellRegions;
  Array<std::uint8_t> cellFrames;
  /// Orientation of each cell, where it is not to be read off the positions: cells may then be
  /// inside out and overlap in space (virtual layers); empty: from the positions.
  Array<std::int8_t> cellSigns;
};

/// @brief A validated control mesh: positions, complex and boundary features
/// (converters/README.md, "Control asset"). Immutable and cheap to copy.
///
/// Edges and facets are numbered in lexicographic order of their sorted vertices and stored
/// ascending. The boundary may touch itself in vertices and edges.
class ControlMesh {
 public:
  /// @throws InputError naming the place ("tetrahedra[3]") and the reason: index out of range,
  /// repeated vertex, non-finite number, degenerate or overlapping cells, a facet of three cells,
  /// a crease that is no boundary edge. Cancelled
  static ControlMesh build(ControlMeshInput input, const Context& context = {});

  const Array<Vec3>& positions() const { return positions_; }
  const std::shared_ptr<const Complex>& complex() const { return complex_; }
  /// Vertices that stay where they are, ascending.
  const std::vector<Index>& corners() const { return corners_; }

  /// The edge (a,b) as seen from a; throws InputError("", ...) when there is none.
  EdgeRef edge(Index a, Index b) const;
  /// The facet (a,b,c) in that order.
  FacetRef facet(Index a, Index b, Index c) const;
  /// Name of a cell in messages: "tetrahedra[3]".
  static std::string cellName(const Complex& complex, Index cell);

 private:
  Array<Vec3> positions_;
  std::shared_ptr<const Complex> complex_;
  std::vector<Index> corners_;
};

/// Six times the signed volume of a cell, as its tables order it: the sum over its outward facets
/// seen from the centroid, which is right for non-convex octahedra too.
double cellVolume6(const Complex& complex, const Array<Vec3>& positions, Index cell);

}  // namespace octet
