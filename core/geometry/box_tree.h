// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numeric>
#include <utility>

#include "box_bins.h"

namespace octet {

/// Do two boxes share volume?
inline bool meet(const Box& a, const Box& b) {
  return (a.min.array() < b.max.array()).all() && (b.min.array() < a.max.array()).all();
}

/// Do two boxes share a point?
inline bool touch(const Box& a, const Box& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

/// @brief Boxes of any sizes, in a tree of boxes around halves of them. Queries may run from many
/// threads.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::vector<Box> boxes)
      : boxes_(std::move(boxes)), order_(boxes_.size()), nodes_(4 * boxes_.size() + 4) {
    std::iota(order_.begin(), order_.end(), 0);
    build(0, 0, order_.size());
  }

  const Box& box(Index k) const { return boxes_[k]; }

  /// Calls `visit(k)` for every box that shares volume with `box`.
  template <typename Visit>
  void visitMeeting(const Box& box, const Visit& visit) const {
    descend([&](const Box& other) { return meet(other, box); }, visit, 0, 0, order_.size());
  }

  /// Calls `visit(k)` for every box that shares a point with `box`; flat boxes too.
  template <typename Visit>
  void visitTouching(const Box& box, const Visit& visit) const {
    descend([&](const Box& other) { return touch(other, box); }, visit, 0, 0, order_.size());
  }

  /// @brief Looks for the item nearest to a point: `distance2(k)` is the squared distance to what
  /// box k holds. Calls it for few more items than the nearest.
  /// @return the item and its squared distance; kNone when there is none nearer than `within2`.
  template <typename Distance2>
  std::pair<Index, double> nearest(const Vec3& p, const Distance2& distance2,
                                   double within2 = HUGE_VAL) const {
    std::pair<Index, double> best = {kNone, within2};
    if (!order_.empty()) approach(p, distance2, 0, 0, order_.size(), &best);
    return best;
  }

 private:
  static constexpr std::size_t kLeafSize = 4;

  static double distance2To(const Box& box, const Vec3& p) {
    return (p - p.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm();
  }

  void build(std::size_t node, std::size_t begin, std::size_t end) {
    Box& all = nodes_[node];
    for (std::size_t k = begin; k < end; ++k) {
      all.extend(boxes_[order_[k]].min);
      all.extend(boxes_[order_[k]].max);
    }
    if (end - begin <= kLeafSize) return;
    int axis = 0;
    all.size().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto centre = [&](Index k) { return boxes_[k].min[axis] + boxes_[k].max[axis]; };
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(end),
                     [&](Index a, Index b) { return centre(a) < centre(b); });
    build(2 * node + 1, begin, middle);
    build(2 * node + 2, middle, end);
  }

  template <typename Meets, typename Visit>
  void descend(const Meets& meets, const Visit& visit, std::size_t node, std::size_t begin,
               std::size_t end) const {
    if (!meets(nodes_[node])) return;
    if (end - begin <= kLeafSize) {
      for (std::size_t k = begin; k < end; ++k) {
        if (meets(boxes_[order_[k]])) visit(order_[k]);
      }
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    descend(meets, visit, 2 * node + 1, begin, middle);
    descend(meets, visit, 2 * node + 2, middle, end);
  }

  template <typename Distance2>
  void approach(const Vec3& p, const Distance2& distance2, std::size_t node, std::size_t begin,
                std::size_t end, std::pair<Index, double>* best) const {
    if (end - begin <= kLeafSize) {
      for (std::size_t k = begin; k < end; ++k) {
        if (distance2To(boxes_[order_[k]], p) >= best->second) continue;
        const double d = distance2(order_[k]);
        if (d < best->second) *best = {order_[k], d};
      }
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2, left = 2 * node + 1, right = left + 1;
    const double toLeft = distance2To(nodes_[left], p), toRight = distance2To(nodes_[right], p);
    const auto goLeft = [&] {
      if (toLeft < best->second) approach(p, distance2, left, begin, middle, best);
    };
    if (toLeft <= toRight) goLeft();
    if (toRight < best->second) approach(p, distance2, right, middle, end, best);
    if (toLeft > toRight) goLeft();
  }

  std::vector<Box> boxes_;
  std::vector<Index> order_;
  std::vector<Box> nodes_;  // children of node k: 2 k + 1, 2 k + 2
};

}  // namespace octet
