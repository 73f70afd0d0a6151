// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// @brief The cells at a vertex, read by vertices.
class CellsAt {
 public:
  CellsAt(const Complex& complex, Index centre) : c_(complex), centre_(centre) {
    c_.visitVertexStar(centre, [&](const CellAtVertex& at) { cells_.push_back(at.cell); });
  }

  const std::vector<Index>& cells() const { return cells_; }
  std::vector<Index> with(Index vertex) const {
    std::vector<Index> found;
    for (const Index cell : cells_) {
      if (place(cell, vertex) >= 0) found.push_back(cell);
    }
    return found;
  }
  bool has(Index cell, Index vertex) const { return place(cell, vertex) >= 0; }
  bool isTet(Index cell) const { return c_.isTet(cell); }
  std::vector<Index> vertices(Index cell) const {
    std::vector<Index> list;
    for (int k = 0; k < c_.cellVertexCount(cell); ++k) list.push_back(c_.cellVertex(cell, k));
    return list;
  }
  /// The vertex opposite another in an octahedron.
  Index opposite(Index oct, Index vertex) const {
    return c_.cellVertex(oct, Octahedron::opposite[place(oct, vertex)]);
  }
  /// The two vertices w of a cell for which (centre, a, w) is one of its facets, ascending.
  std::pair<Index, Index> beside(Index cell, Index a) const {
    std::pair<Index, Index> two{kNone, kNone};
    for (const Index w : vertices(cell)) {
      if (w == centre_ || w == a) continue;
      if (!isTet(cell)) {
        const Index far = opposite(cell, w);
        if (far == centre_ || far == a) continue;
      }
      (two.first == kNone ? two.first : two.second) = w;
    }
    if (two.first > two.second) std::swap(two.first, two.second);
    return two;
  }
  /// Is (centre, a, b) a facet?
  bool facet(Index a, Index b) const {
    return std::any_of(cells_.begin(), cells_.end(), [&](Index cell) {
      if (!has(cell, a) || !has(cell, b)) return false;
      return isTet(cell) || (opposite(cell, a) != b && opposite(cell, a) != centre_ &&
                             opposite(cell, b) != centre_);
    });
  }

 private:
  int place(Index cell, Index vertex) const {
    for (int k = 0; k < c_.cellVertexCount(cell); ++k) {
      if (c_.cellVertex(cell, k) == vertex) return k;
    }
    return -1;
  }

  const Complex& c_;
  Index centre_;
  std::vector<Index> cells_;
};

}  // namespace octet
