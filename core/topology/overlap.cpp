// SPDX-License-Identifier: Apache-2.0
#include "overlap.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "../geometry/box_tree.h"

namespace octet {
namespace {

/// Depth, relative to the smaller cell's size, from which cells overlap; less is rounding.
constexpr double kDepth = 1e-7;
/// Sine of the angle below which two edges count as parallel.
constexpr double kParallel = 1e-9;

using Corners = std::array<Vec3, 4>;

double volume6(const Corners& p) { return (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])); }

/// Keeps the tetrahedra from number `begin` on, if all have the same orientation.
bool keepIfOriented(std::vector<Corners>* parts, std::size_t begin) {
  bool positive = false, negative = false;
  for (std::size_t k = begin; k < parts->size(); ++k) {
    const double volume = volume6((*parts)[k]);
    positive |= volume > 0;
    negative |= volume < 0;
  }
  if (positive && negative) parts->resize(begin);
  return !(positive && negative);
}

/// Appends the tetrahedra around one of an octahedron's diagonals or around its centroid, whichever
/// fill it; none when it is so concave that neither do.
void appendOctahedron(const std::array<Vec3, 6>& p, std::vector<Corners>* parts) {
  // The diagonal, then the ring around it.
  constexpr int kDiagonals[3][6] = {{0, 5, 1, 2, 3, 4}, {1, 3, 0, 2, 5, 4}, {2, 4, 0, 1, 5, 3}};
  const std::size_t begin = parts->size();
  for (const auto& [from, to, a, b, c, d] : kDiagonals) {
    parts->push_back({p[from], p[to], p[a], p[b]});
    parts->push_back({p[from], p[to], p[b], p[c]});
    parts->push_back({p[from], p[to], p[c], p[d]});
    parts->push_back({p[from], p[to], p[d], p[a]});
    if (keepIfOriented(parts, begin)) return;
  }
  const Vec3 centroid = (p[0] + p[1] + p[2] + p[3] + p[4] + p[5]) / 6;
  for (const auto& f : Octahedron::facets) {
    parts->push_back({centroid, p[f[0]], p[f[1]], p[f[2]]});
  }
  keepIfOriented(parts, begin);
}

/// Is there room between two tetrahedra along an axis, but for `depth`?
bool separatedAlong(const Vec3& axis, const Corners& a, const Corners& b, double depth) {
  double aMin = HUGE_VAL, aMax = -HUGE_VAL, bMin = HUGE_VAL, bMax = -HUGE_VAL;
  for (int k = 0; k < 4; ++k) {
    const double x = axis.dot(a[k] - a[0]), y = axis.dot(b[k] - a[0]);
    aMin = std::min(aMin, x);
    aMax = std::max(aMax, x);
    bMin = std::min(bMin, y);
    bMax = std::max(bMax, y);
  }
  return std::min(aMax - bMin, bMax - aMin) <= depth * axis.norm();
}

/// Convex bodies are apart when they are so along a facet's normal or along the cross product of
/// two edges.
bool separated(const Corners& a, const Corners& b, double depth) {
  constexpr int kFacets[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  for (const Corners* p : {&a, &b}) {
    for (const auto& [i, j, k] : kFacets) {
      const Vec3 normal = ((*p)[j] - (*p)[i]).cross((*p)[k] - (*p)[i]);
      if (separatedAlong(normal, a, b, depth)) return true;
    }
  }
  for (const auto& [i, j] : kEdges) {
    for (const auto& [k, l] : kEdges) {
      const Vec3 e = a[j] - a[i], f = b[l] - b[k], axis = e.cross(f);
      if (axis.norm() <= kParallel * e.norm() * f.norm()) continue;
      if (separatedAlong(axis, a, b, depth)) return true;
    }
  }
  return false;
}

class OverlapFinder {
 public:
  OverlapFinder(const Complex& complex, const Array<Vec3>& positions)
      : c_(complex), x_(positions), tree_(boxes()) {
    parts_.reserve(static_cast<std::size_t>(c_.tetCount()) + 4 * c_.octs.size());
    for (const auto& [a, b, c, d] : c_.tets) parts_.push_back({x_[a], x_[b], x_[c], x_[d]});
    for (const auto& [a, b, c, d, e, f] : c_.octs) {
      octParts_.push_back(parts_.size());
      appendOctahedron({x_[a], x_[b], x_[c], x_[d], x_[e], x_[f]}, &parts_);
    }
    octParts_.push_back(parts_.size());
  }

  std::optional<Overlap> run(const Context& context) const {
    // The lowest cell that overlaps an earlier one, so that the message does not depend on threads.
    const Index cells = c_.cellCount();
    const Index first = tbb::parallel_reduce(
        tbb::blocked_range<Index>(0, cells, 64), cells,
        [&](const tbb::blocked_range<Index>& range, Index best) {
          context.poll();
          for (Index k = range.begin(); k != range.end() && k < best; ++k) {
            if (earlierOverlap(k) != kNone) return k;
          }
          return best;
        },
        [](Index a, Index b) { return std::min(a, b); });
    if (first == cells) return std::nullopt;
    return Overlap{first, earlierOverlap(first)};
  }

 private:
  std::vector<Box> boxes() const {
    std::vector<Box> result(c_.cellCount());
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
        result[cell].extend(x_[c_.cellVertex(cell, i)]);
      }
    }
    return result;
  }

  struct Parts {
    const Corners *first, *last;
    const Corners* begin() const { return first; }
    const Corners* end() const { return last; }
  };

  Parts parts(Index cell) const {
    const Corners* all = parts_.data();
    if (c_.isTet(cell)) return {all + cell, all + cell + 1};
    const Index oct = cell - c_.tetCount();
    return {all + octParts_[oct], all + octParts_[oct + 1]};
  }

  Index earlierOverlap(Index cell) const {
    const Box& box = tree_.box(cell);
    Index found = kNone;
    tree_.visitMeeting(box, [&](Index other) {
      if (other >= cell || (found != kNone && other > found)) return;
      const double size = std::min(box.size().norm(), tree_.box(other).size().norm());
      if (overlap(parts(cell), parts(other), kDepth * size)) found = other;
    });
    return found;
  }

  static bool overlap(const Parts& a, const Parts& b, double depth) {
    for (const Corners& p : a) {
      for (const Corners& q : b) {
        if (!separated(p, q, depth)) return true;
      }
    }
    return false;
  }

  const Complex& c_;
  const Array<Vec3>& x_;
  BoxTree tree_;
  std::vector<Corners> parts_;         // of the tetrahedra, one each, then of the octahedra
  std::vector<std::size_t> octParts_;  // where those of each octahedron begin
};

}  // namespace

std::optional<Overlap> findOverlap(const Complex& complex, const Array<Vec3>& positions,
                                   const Context& context) {
  context.poll();
  const OverlapFinder finder(complex, positions);
  context.poll();
  return finder.run(context);
}

}  // namespace octet
