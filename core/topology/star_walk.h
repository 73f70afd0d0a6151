// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "../rules/star.h"
#include "complex.h"

namespace octet {

/// @brief A star as it lies in a mesh: the vertex that bears each label, and the star by labels.
struct LabelledStar {
  std::vector<Index> vertices;  ///< vertices[0] is the centre
  Star star;
};

/// @brief Labels the star of a vertex by a walk over its cells from one facet at the vertex to the
/// next. Labels depend on where the walk begins, and on nothing else of the mesh's numbering: the
/// least result over all beginnings that are alike is a canonical form of the star.
///
/// @param first  vertices that get labels 1, 2, .. before the walk
/// @param cells  where it begins; each has three labelled vertices, m among them, when it is
/// reached
/// @return none where the cells at the vertex are not joined by facets at it, or too many
std::optional<LabelledStar> walkStar(const Complex& complex, Index centre,
                                     const std::vector<Index>& first,
                                     const std::vector<Index>& cells);

/// @brief The way from the centre of a star to its vertices and their children: for every label the
/// fine vertex in its place, and the coarse edges that lead to it.
class StarPaths {
 public:
  /// @param vertices  by label, the centre first
  StarPaths(const Complex& complex, const std::vector<Index>& vertices);

  /// Has every vertex of the star one place only, and one way to it?
  bool unique() const { return unique_; }
  /// The fine vertex in the place of a label.
  Index place(int label) const { return places_[static_cast<std::size_t>(label)]; }
  /// The coarse edges that lead to the star's vertices, ascending.
  const std::vector<Index>& edges() const { return edges_; }
  /// Calls `add(number in edges(), share)` for a chain of edges from the centre to a label: the
  /// edge, or the mean of the four paths across an octahedron. Shares are along stored directions.
  template <typename Add>
  void visit(int label, const Add& add) const {
    for (std::size_t k = begin_[label]; k < begin_[label + 1]; ++k) {
      add(steps_[k].edge, steps_[k].share);
    }
  }

 private:
  struct Step {
    std::size_t edge;
    double share;
  };
  bool unique_ = true;
  std::vector<Index> places_, edges_;
  std::vector<std::size_t> begin_;  // per label: in steps_
  std::vector<Step> steps_;
};

}  // namespace octet
