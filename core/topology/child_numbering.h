// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/types.h"

namespace octet {

/// The kind of coarse simplex that a simplex of the next level lies in.
enum class Origin : std::uint8_t { Vertex, Edge, Facet, Tetrahedron, Octahedron };

/// The coarse simplex that a fine one lies in, and which of its children it is.
struct ChildOf {
  Origin origin;
  Index parent;  ///< its number among the simplices of that kind; octahedra count from 0
  int place;
};

/// @brief Numbers the children of one split, there and back (SCHEME.md section 3): the only place
/// that does arithmetic on their indices. Built from the coarse level's counts.
///
/// Places count as follows. Halves of an edge: 0 at its start, 1 at its end. Edges and facets
/// inside a facet: the place of the corner that they cut off or keep; 3 is the middle facet.
/// Children of a tetrahedron: the corner that facets cut off and tetrahedra keep. Children of an
/// octahedron: the local edge that a spoke leads to, the facets inside in the split's order
/// (SplitTables), the local facet of a tetrahedron, the corner of an octahedron.
class ChildNumbering {
 public:
  ChildNumbering(Index vertices, Index edges, Index facets, Index tets, Index octs)
      : vertices_(vertices), edges_(edges), facets_(facets), tets_(tets), octs_(octs) {}

  /// @name Counts of the fine level, which may be more than an Index can hold
  /// @{
  std::int64_t vertexCount() const { return std::int64_t{vertices_} + edges_ + octs_; }
  std::int64_t edgeCount() const {
    return 2 * std::int64_t{edges_} + 3 * std::int64_t{facets_} + 12 * std::int64_t{octs_};
  }
  std::int64_t facetCount() const {
    return 4 * std::int64_t{facets_} + 4 * std::int64_t{tets_} + 24 * std::int64_t{octs_};
  }
  std::int64_t tetCount() const { return 4 * std::int64_t{tets_} + 8 * std::int64_t{octs_}; }
  std::int64_t octCount() const { return std::int64_t{tets_} + 6 * std::int64_t{octs_}; }
  std::int64_t cellCount() const { return tetCount() + octCount(); }
  /// @}

  /// @name Children; coarse vertices keep their numbers
  /// @{
  Index midpoint(Index edge) const { return vertices_ + edge; }
  Index centre(Index oct) const { return vertices_ + edges_ + oct; }

  Index half(Index edge, int end) const { return 2 * edge + end; }
  Index cut(Index facet, int corner) const { return 2 * edges_ + 3 * facet + corner; }
  Index spoke(Index oct, int edge) const { return 2 * edges_ + 3 * facets_ + 12 * oct + edge; }

  Index onFacet(Index facet, int corner) const { return 4 * facet + corner; }
  Index inTet(Index tet, int corner) const { return 4 * facets_ + 4 * tet + corner; }
  Index inOct(Index oct, int k) const { return 4 * facets_ + 4 * tets_ + 24 * oct + k; }

  Index cornerTet(Index tet, int corner) const { return 4 * tet + corner; }
  Index innerTet(Index oct, int facet) const { return 4 * tets_ + 8 * oct + facet; }
  /// Octahedra are numbered as cells, after the tetrahedra.
  Index innerOct(Index tet) const { return fineTets() + tet; }
  Index cornerOct(Index oct, int corner) const { return fineTets() + tets_ + 6 * oct + corner; }
  /// The child that keeps a corner of a coarse cell.
  Index cornerChild(Index cell, int corner) const {
    return cell < tets_ ? cornerTet(cell, corner) : cornerOct(cell - tets_, corner);
  }
  /// The octahedron in a coarse tetrahedron, or the tetrahedron at a facet of a coarse octahedron.
  Index innerChild(Index cell, int facet) const {
    return cell < tets_ ? innerOct(cell) : innerTet(cell - tets_, facet);
  }
  /// @}

  /// @name Parents
  /// @{
  ChildOf vertex(Index fine) const {
    if (fine < vertices_) return {Origin::Vertex, fine, 0};
    const Index made = fine - vertices_;
    return made < edges_ ? ChildOf{Origin::Edge, made, 0}
                         : ChildOf{Origin::Octahedron, made - edges_, 0};
  }
  ChildOf edge(Index fine) const {
    if (fine < cut(0, 0)) return divided(Origin::Edge, fine, 2);
    return fine < spoke(0, 0) ? divided(Origin::Facet, fine - cut(0, 0), 3)
                              : divided(Origin::Octahedron, fine - spoke(0, 0), 12);
  }
  ChildOf facet(Index fine) const {
    if (fine < inTet(0, 0)) return divided(Origin::Facet, fine, 4);
    return fine < inOct(0, 0) ? divided(Origin::Tetrahedron, fine - inTet(0, 0), 4)
                              : divided(Origin::Octahedron, fine - inOct(0, 0), 24);
  }
  /// Of a tetrahedron or octahedron in either; the place of what is not at a corner of a coarse
  /// tetrahedron is 0.
  ChildOf cell(Index fine) const {
    if (fine < innerTet(0, 0)) return divided(Origin::Tetrahedron, fine, 4);
    if (fine < innerOct(0)) return divided(Origin::Octahedron, fine - innerTet(0, 0), 8);
    return fine < cornerOct(0, 0) ? divided(Origin::Tetrahedron, fine - innerOct(0), 1)
                                  : divided(Origin::Octahedron, fine - cornerOct(0, 0), 6);
  }
  /// The coarse cell that a fine one lies in.
  Index parentCell(Index fine) const {
    const ChildOf child = cell(fine);
    return child.origin == Origin::Tetrahedron ? child.parent : tets_ + child.parent;
  }
  /// @}

  /// Number of a facet inside a coarse cell among all such: those of tetrahedra, then octahedra.
  Index insideNumber(Index fineFacet) const { return fineFacet - inTet(0, 0); }

 private:
  Index fineTets() const { return 4 * tets_ + 8 * octs_; }
  static ChildOf divided(Origin origin, Index number, Index children) {
    return {origin, number / children, static_cast<int>(number % children)};
  }

  Index vertices_, edges_, facets_, tets_, octs_;
};

}  // namespace octet
