// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "../geometry/box_bins.h"
#include "potential_field.h"

namespace octet {

/// @brief Line integrals of a piecewise quadratic vector potential along the edges of an integer
/// lattice of n x n x n corners, and how much of each edge the pieces cover. Pieces are given in
/// lattice coordinates; circulations do not depend on the scale. Exact for each piece.
class EdgeCirculations {
 public:
  explicit EdgeCirculations(int corners);

  /// Forgets all pieces.
  void clear();
  /// Was anything added?
  bool used() const { return used_; }
  /// Does a box hold any part of the lattice's lines?
  bool meets(const Box& box) const;
  void add(const PotentialPiece& piece);

  /// Along `axis`, from corner `c` to the next.
  double circulation(int axis, const std::array<int, 3>& c) const {
    return edges_[axis][index(c)].sum;
  }
  /// From 0, outside the pieces, to 1, inside; between where pieces fold over one another.
  double coverage(int axis, const std::array<int, 3>& c) const {
    const double length = edges_[axis][index(c)].length;
    return length < 0 ? 0.5 : length > 1.5 ? 0.5 : 1 - std::abs(1 - length);
  }

 private:
  struct Edge {
    double sum, length;
  };
  class Quadratic;

  std::size_t index(const std::array<int, 3>& c) const {
    return (static_cast<std::size_t>(c[0]) * corners_ + c[1]) * corners_ + c[2];
  }
  void addLine(int axis, std::array<int, 3> at, double from, double to, double sign,
               const std::array<double, 3>& polynomial);

  int corners_;
  bool used_ = false;
  std::array<Array<Edge>, 3> edges_;
};

}  // namespace octet
