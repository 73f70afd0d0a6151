// SPDX-License-Identifier: Apache-2.0
#include "star_reflection.h"

#include <algorithm>
#include <map>

#include "../base/sort_unique.h"
#include "cells_at.h"

namespace octet {
namespace {

/// @brief Builds the reflection of a star that exchanges two vertices a and b, if it has one.
class Reflection {
 public:
  Reflection(const CellsAt& star, Index centre, Index a, Index b)
      : star_(star), upper_(star.with(a)), lower_(star.with(b)), a_(a), b_(b) {
    image_ = {{centre, centre}, {a, b}, {b, a}};
  }

  std::optional<std::map<Index, Index>> find() {
    constexpr std::size_t kFewestCells = 3;
    if (upper_.size() < kFewestCells) return std::nullopt;
    for (const Index cell : upper_) {
      if (star_.has(cell, b_)) return std::nullopt;
    }
    if (!matchRings() || !matchCells()) return std::nullopt;
    for (const Index cell : star_.cells()) {
      for (const Index v : star_.vertices(cell)) image_.emplace(v, v);
    }
    return keepsCells() ? std::make_optional(image_) : std::nullopt;
  }

 private:
  std::vector<Index> ring(const std::vector<Index>& cells, Index axis) const {
    std::vector<Index> list;
    for (const Index cell : cells) {
      const auto [v, w] = star_.beside(cell, axis);
      list.push_back(v);
      list.push_back(w);
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  }

  /// r <-> s where (m, r, s) is a facet.
  bool matchRings() {
    const std::vector<Index> above = ring(upper_, a_), below = ring(lower_, b_);
    for (const Index r : above) {
      if (std::binary_search(below.begin(), below.end(), r)) return false;
    }
    for (const Index r : above) {
      Index match = kNone;
      for (const Index s : below) {
        if (!star_.facet(r, s)) continue;
        if (match != kNone) return false;
        match = s;
      }
      if (match == kNone) return false;
      image_[r] = match;
      image_[match] = r;
    }
    return true;
  }

  /// Cells above go to cells below, and what lies opposite m in them likewise.
  bool matchCells() {
    const Index centre = star_.cells().empty() ? kNone : centreOf();
    for (const Index cell : upper_) {
      auto [v, w] = star_.beside(cell, a_);
      std::pair<Index, Index> wanted = std::minmax(image_[v], image_[w]);
      Index match = kNone;
      for (const Index other : lower_) {
        if (star_.isTet(other) != star_.isTet(cell) || star_.beside(other, b_) != wanted) continue;
        if (match != kNone) return false;
        match = other;
      }
      if (match == kNone) return false;
      if (star_.isTet(cell)) continue;
      const Index far = star_.opposite(cell, centre), near = star_.opposite(match, centre);
      image_[far] = near;
      image_[near] = far;
    }
    return true;
  }

  Index centreOf() const {
    for (const auto& [v, w] : image_) {
      if (v == w) return v;
    }
    return kNone;
  }

  bool keepsCells() const {
    for (const auto& [v, w] : image_) {
      if (image_.at(w) != v) return false;
    }
    std::vector<std::vector<Index>> own, images;
    for (const Index cell : star_.cells()) {
      std::vector<Index> vertices = star_.vertices(cell), mapped;
      for (const Index v : vertices) mapped.push_back(image_.at(v));
      std::sort(vertices.begin(), vertices.end());
      std::sort(mapped.begin(), mapped.end());
      own.push_back(std::move(vertices));
      images.push_back(std::move(mapped));
    }
    std::sort(own.begin(), own.end());
    std::sort(images.begin(), images.end());
    return own == images;
  }

  const CellsAt& star_;
  std::vector<Index> upper_, lower_;
  Index a_, b_;
  std::map<Index, Index> image_;
};

}  // namespace

std::optional<std::vector<std::pair<Index, Index>>> starReflection(const Complex& complex,
                                                                   Index centre, Index a, Index b) {
  const auto image = Reflection(CellsAt(complex, centre), centre, a, b).find();
  if (!image) return std::nullopt;
  return std::vector<std::pair<Index, Index>>(image->begin(), image->end());
}

}  // namespace octet
