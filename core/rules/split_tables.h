// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "cell_tables.h"

/// @file
/// How one cell splits (SCHEME.md section 3), as tables of labels: children, the facets between
/// them and the edges of those facets. Fine vertices of a split cell are labelled: coarse vertex i,
/// then the midpoint of local edge k, then (of an octahedron) the centre.

namespace octet {

/// The local octahedron vertex that is the midpoint of a tetrahedron's local edge, in the child
/// (ab,ac,ad,bd,bc,cd).
inline constexpr std::uint8_t kTetMidpointPlace[6] = {0, 1, 2, 4, 3, 5};

/// The child facet of a coarse cell's child cell: on a coarse facet, or inside the coarse cell.
struct ChildFacet {
  bool inside;
  std::uint8_t facet;        ///< coarse local facet, or number of the inside facet
  std::uint8_t corner;       ///< slot of the corner it keeps; 3: the middle child
  std::uint8_t arrangement;  ///< slots of its vertices (the missing corner, for a middle child)
};

/// An edge between the midpoints of two edges of a coarse facet.
struct CutEdge {
  std::uint8_t facet;   ///< coarse local facet
  std::uint8_t corner;  ///< slot of the corner it cuts off
  std::uint8_t from;    ///< slot towards which its first midpoint lies
};

/// Label of the midpoint between two local vertices.
template <typename Shape>
constexpr int midpointLabel(int i, int j) {
  return Shape::kVertices + kCellTables<Shape>.edgeBetween[i][j];
}
inline constexpr int kCentreLabel = Octahedron::kVertices + Octahedron::kEdges;

/// The split of one shape. Order of the children and of the inside facets: SCHEME.md section 3.
template <typename Shape>
struct SplitTables {
  static constexpr bool kTet = Shape::kVertices == 4;
  static constexpr int kTets = kTet ? 4 : 8, kOcts = kTet ? 1 : 6, kInside = kTet ? 4 : 24;

  std::uint8_t tets[kTets][4], octs[kOcts][6];
  std::uint8_t inside[kInside][3];
  ChildFacet tetFacets[kTets][4], octFacets[kOcts][8];
  /// Edges of the inside facets: between midpoints (a CutEdge), and for an octahedron the spokes
  /// from the centre to the midpoint of a local edge.
  CutEdge insideCuts[kInside][3];
  std::uint8_t insideSpokes[kInside][2];

  static const SplitTables& get() {
    static const SplitTables tables;
    return tables;
  }

  /// The slot of a coarse facet that label `v` stands for in a corner child at slot `corner`:
  /// the corner itself, or the vertex whose edge to the corner it halves; 3 when neither.
  static int slotInCorner(int facet, int corner, int v) {
    const auto& t = Shape::facets[facet];
    for (int s = 0; s < 3; ++s) {
      if (v == (s == corner ? t[s] : midpointLabel<Shape>(t[corner], t[s]))) return s;
    }
    return 3;
  }
  /// The slot that label `v` misses as a midpoint of a coarse facet's edge; 3 when it is none.
  static int slotMissing(int facet, int v) {
    const auto& t = Shape::facets[facet];
    for (int s = 0; s < 3; ++s) {
      if (v == midpointLabel<Shape>(t[(s + 1) % 3], t[(s + 2) % 3])) return s;
    }
    return 3;
  }
  /// Where a facet with three given labels lies.
  ChildFacet childFacet(int a, int b, int c) const;
  /// The edge between two midpoints.
  static CutEdge cut(int from, int to);

 private:
  SplitTables() {
    fillChildren();
    for (int c = 0; c < kTets; ++c) fillFacets<Tetrahedron>(tets[c], tetFacets[c]);
    for (int c = 0; c < kOcts; ++c) fillFacets<Octahedron>(octs[c], octFacets[c]);
    for (int f = 0; f < kInside; ++f) {
      const auto& v = inside[f];
      if constexpr (kTet) {
        for (int k = 0; k < 3; ++k) insideCuts[f][k] = cut(v[k], v[(k + 1) % 3]);
      } else {
        insideSpokes[f][0] = static_cast<std::uint8_t>(v[1] - Shape::kVertices);
        insideSpokes[f][1] = static_cast<std::uint8_t>(v[2] - Shape::kVertices);
        insideCuts[f][0] = cut(v[1], v[2]);
      }
    }
  }

  void fillChildren() {
    const auto mid = [](int i, int j) {
      return static_cast<std::uint8_t>(i == j ? i : midpointLabel<Shape>(i, j));
    };
    int n = 0;
    if constexpr (kTet) {
      for (int i = 0; i < 4; ++i) {
        for (int s = 0; s < 4; ++s) tets[i][s] = mid(i, s);
        int k = 0;
        for (int j = 0; j < 4; ++j) {
          if (j != i) inside[i][k++] = mid(i, j);
        }
      }
      for (int e = 0; e < 6; ++e) {
        octs[0][kTetMidpointPlace[e]] = mid(Shape::edges[e][0], Shape::edges[e][1]);
      }
    } else {
      for (int f = 0; f < 8; ++f) {
        const auto& [i, j, l] = Shape::facets[f];
        const std::uint8_t child[4] = {mid(i, j), mid(j, l), mid(i, l), kCentreLabel};
        std::copy(child, child + 4, tets[f]);
      }
      for (int i = 0; i < 6; ++i) {
        for (int s = 0; s < 6; ++s) {
          octs[i][s] = s == Shape::opposite[i] ? kCentreLabel : mid(i, s);
        }
        for (int p = 0; p < 6; ++p) {
          for (int q = p + 1; q < 6; ++q) {
            const auto& between = kCellTables<Shape>.edgeBetween;
            if (between[i][p] < 0 || between[i][q] < 0 || between[p][q] < 0) continue;
            inside[n][0] = kCentreLabel;
            inside[n][1] = mid(i, p);
            inside[n++][2] = mid(i, q);
          }
        }
      }
    }
  }

  template <typename Child>
  void fillFacets(const std::uint8_t* child, ChildFacet* out) const {
    for (int k = 0; k < Child::kFacets; ++k) {
      const auto& t = Child::facets[k];
      out[k] = childFacet(child[t[0]], child[t[1]], child[t[2]]);
    }
  }
};

template <typename Shape>
ChildFacet SplitTables<Shape>::childFacet(int a, int b, int c) const {
  for (std::uint8_t f = 0; f < Shape::kFacets; ++f) {
    for (std::uint8_t corner = 0; corner < 3; ++corner) {
      const int s[3] = {slotInCorner(f, corner, a), slotInCorner(f, corner, b),
                        slotInCorner(f, corner, c)};
      if (s[0] < 3 && s[1] < 3 && s[2] < 3) {
        return {false, f, corner, permutationOf(s[0], s[1])};
      }
    }
    const int s[3] = {slotMissing(f, a), slotMissing(f, b), slotMissing(f, c)};
    if (s[0] < 3 && s[1] < 3 && s[2] < 3) return {false, f, 3, permutationOf(s[0], s[1])};
  }
  for (std::uint8_t f = 0; f < kInside; ++f) {
    int place[3] = {-1, -1, -1};
    const int labels[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        if (inside[f][j] == labels[k]) place[k] = j;
      }
    }
    if (place[0] >= 0 && place[1] >= 0 && place[2] >= 0) {
      return {true, f, 0, permutationOf(place[0], place[1])};
    }
  }
  return {};
}

template <typename Shape>
CutEdge SplitTables<Shape>::cut(int from, int to) {
  for (std::uint8_t f = 0; f < Shape::kFacets; ++f) {
    const int missingFrom = slotMissing(f, from), missingTo = slotMissing(f, to);
    if (missingFrom == 3 || missingTo == 3) continue;
    // `from` lies between the corner and the slot that `to` misses.
    const int corner = 3 - missingFrom - missingTo;
    return {f, static_cast<std::uint8_t>(corner), static_cast<std::uint8_t>(missingTo)};
  }
  return {};
}

}  // namespace octet
