// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "../rules/lattice.h"

namespace octet {

/// @brief The 14 cells at a vertex of the face-centred cubic lattice (even integer points), and
/// which subsets of them meet at the vertex as a solid with a manifold boundary does.
///
/// Tetrahedra come first, one in each octant (bit k of `t` tells whether coordinate k is negative),
/// then octahedra towards +x, -x, +y, -y, +z, -z.
class StarPatterns {
 public:
  static constexpr int kTets = 8, kOcts = 6, kCells = kTets + kOcts;
  static constexpr std::uint16_t kAll = (1u << kCells) - 1;

  StarPatterns();

  /// Is the link of this subset of cells empty, a disc or the whole sphere?
  bool manifold(std::uint16_t cells) const { return manifold_[cells]; }
  /// The other vertices of cell `c`, relative to the vertex: 3 or 5 of them.
  const std::vector<Int3>& vertices(int c) const { return vertices_[c]; }
  /// All of them: 12 neighbours, then 6 across octahedra.
  const std::vector<Int3>& around() const { return around_; }

  /// An edge or facet at the vertex: its other vertices among `around`, and the cells at it.
  struct Joint {
    std::vector<int> vertices;
    std::uint16_t cells;
  };
  /// 12 edges, then 24 facets.
  const std::vector<Joint>& joints() const { return joints_; }

 private:
  void findJoints();

  std::vector<Int3> vertices_[kCells], around_;
  std::vector<bool> manifold_;
  std::vector<Joint> joints_;
};

}  // namespace octet
