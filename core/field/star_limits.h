// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>

#include "../refine/interior_limits.h"

namespace octet {

/// @brief Holds the exact limits of 0-forms at irregular vertices inside, as left eigenvectors of
/// their stars' matrices (SCHEME.md section 6b). Weights are shared by equal stars.
class StarLimits {
 public:
  StarLimits() = default;
  /// @param complex  the level whose values are given; a control mesh has none
  explicit StarLimits(const Complex& complex);

  /// The limit at a vertex, `at(vertex)` giving values; none where there is no mask.
  template <typename At>
  std::optional<double> value(Index vertex, const At& at) const;

 private:
  Array<std::uint32_t> stars_;  // per vertex: place in limits_, or kNoStar
  std::vector<StarLimit> limits_;
  static constexpr std::uint32_t kNoStar = 0xffffffffu;
};

template <typename At>
std::optional<double> StarLimits::value(Index vertex, const At& at) const {
  if (stars_.empty() || stars_[vertex] == kNoStar) return std::nullopt;
  const StarLimit& star = limits_[stars_[vertex]];
  double sum = 0;
  for (std::size_t a = 0; a < star.vertices.size(); ++a) {
    sum += (*star.weights)[static_cast<Eigen::Index>(a)] * at(star.vertices[a]);
  }
  return sum;
}

}  // namespace octet
