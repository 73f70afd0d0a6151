// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "../topology/star_walk.h"

namespace octet {

/// What a vertex' star is to the rules for irregular stars (SCHEME.md section 6b).
enum class StarKind : std::uint8_t {
  Plain,  ///< no irregular edge: R or X1
  Line,   ///< X2: two irregular edges, and a reflection that exchanges them
  Other,  ///< X3: any other with irregular edges
  Wall,   ///< on the boundary
};

/// A vertex on a line: the ends of its axis, and the reflection as pairs (vertex, image).
struct LineStar {
  Index centre, up, down;
  std::vector<std::pair<Index, Index>> mirror;

  Index imageOf(Index vertex) const;
};

/// The vertices around a vertex on a line of tetrahedra, in the names of section 6b.
struct LineNames {
  Index centre, up, down;
  std::vector<Index> upper, lower, beyond;  ///< r_j, s_j, o_j

  int size() const { return static_cast<int>(upper.size()); }
  /// All of them: m, a, b, r_0.., s_0.., o_0..
  std::vector<Index> list() const;
};

/// @brief Finds the irregular interior edges of a level (others than two tetrahedra and two
/// octahedra around them) and the vertices at them. Only parts of control edges can be irregular,
/// so that the number grows with 2^level.
class IrregularStars {
 public:
  explicit IrregularStars(const Complex& complex);

  const Complex& complex() const { return c_; }
  StarKind kind(Index vertex) const { return kinds_[vertex]; }
  const std::vector<LineStar>& lines() const { return lines_; }
  /// The line through a vertex of kind Line.
  const LineStar& line(Index vertex) const;
  const std::vector<Index>& others() const { return others_; }

  /// Names around a vertex on a line; an empty list of r_j where octahedra lie around the line or
  /// the names do not exclude each other.
  LineNames names(const LineStar& line) const;

 private:
  const Complex& c_;
  Array<StarKind> kinds_;
  std::vector<LineStar> lines_;
  std::vector<Index> others_;
};

}  // namespace octet
