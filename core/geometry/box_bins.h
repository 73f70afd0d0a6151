// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../base/types.h"

namespace octet {

/// An axis-aligned box.
struct Box {
  Vec3 min = Vec3::Constant(HUGE_VAL), max = Vec3::Constant(-HUGE_VAL);

  void extend(const Vec3& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  bool contains(const Vec3& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  bool empty() const { return !(min.array() <= max.array()).all(); }
  Vec3 size() const { return max - min; }
};

/// @brief A uniform grid over many small boxes: which of them may hold a point.
/// Memory is linear in the number of boxes when they are of similar size; queries may run from many
/// threads.
class BoxBins {
 public:
  BoxBins() = default;

  /// @param count  number of boxes; `boxOf(i)` returns box i.
  template <typename BoxOf>
  BoxBins(Index count, const BoxOf& boxOf) {
    for (Index i = 0; i < count; ++i) {
      const Box box = boxOf(i);
      bounds_.extend(box.min);
      bounds_.extend(box.max);
    }
    if (count == 0) return;
    // About one box per bin, bins as close to cubes as the bounds allow.
    const Vec3 size = bounds_.size().cwiseMax(bounds_.size().maxCoeff() * 1e-6 + 1e-300);
    const double edge = std::cbrt(size.prod() / count);
    for (int k = 0; k < 3; ++k) {
      bins_[k] = static_cast<Index>(std::clamp(std::floor(size[k] / edge), 1.0, 1024.0));
      perUnit_[k] = bins_[k] / size[k];
    }
    begin_.assign(static_cast<std::size_t>(bins_[0]) * bins_[1] * bins_[2] + 1, 0);
    for (Index i = 0; i < count; ++i) visitBins(boxOf(i), [&](std::size_t b) { ++begin_[b + 1]; });
    for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
    items_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (Index i = 0; i < count; ++i) {
      visitBins(boxOf(i), [&](std::size_t b) { items_[next[b]++] = i; });
    }
  }

  const Box& bounds() const { return bounds_; }

  /// Calls `visit(i)`, i ascending, for every box whose bin holds the point, until it returns true.
  /// @return whether some visit did.
  template <typename Visit>
  bool visitAt(const Vec3& p, const Visit& visit) const {
    if (begin_.empty() || !bounds_.contains(p)) return false;
    const std::size_t b = binOf(coordinate(p, 0), coordinate(p, 1), coordinate(p, 2));
    for (std::size_t k = begin_[b]; k < begin_[b + 1]; ++k) {
      if (visit(items_[k])) return true;
    }
    return false;
  }

 private:
  Index coordinate(const Vec3& p, int k) const {
    const double x = (p[k] - bounds_.min[k]) * perUnit_[k];
    return static_cast<Index>(std::clamp(x, 0.0, bins_[k] - 1.0));
  }
  std::size_t binOf(Index i, Index j, Index k) const {
    return (static_cast<std::size_t>(i) * bins_[1] + j) * bins_[2] + k;
  }
  template <typename Visit>
  void visitBins(const Box& box, const Visit& visit) const {
    for (Index i = coordinate(box.min, 0); i <= coordinate(box.max, 0); ++i) {
      for (Index j = coordinate(box.min, 1); j <= coordinate(box.max, 1); ++j) {
        for (Index k = coordinate(box.min, 2); k <= coordinate(box.max, 2); ++k) {
          visit(binOf(i, j, k));
        }
      }
    }
  }

  Box bounds_;
  std::array<Index, 3> bins_{};
  Vec3 perUnit_ = Vec3::Zero();
  std::vector<std::size_t> begin_;
  std::vector<Index> items_;
};

}  // namespace octet
