// SPDX-License-Identifier: Apache-2.0
#include "overlap.h"

#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "../geometry/box_bins.h"

namespace octet {
namespace {

/// Depth below a facet's plane, relative to the cell's size, from which a point counts as inside.
constexpr double kInside = 1e-7;

class OverlapFinder {
 public:
  OverlapFinder(const Complex& complex, const Array<Vec3>& positions)
      : c_(complex), x_(positions), bins_(complex.cellCount(), [&](Index k) { return box(k); }) {}

  std::optional<Overlap> run() const {
    // The lowest probe that overlaps, so that the message does not depend on threads.
    const Index cells = c_.cellCount(), probes = cells + c_.vertexCount();
    const Index first = tbb::parallel_reduce(
        tbb::blocked_range<Index>(0, probes, 256), probes,
        [&](const tbb::blocked_range<Index>& range, Index best) {
          for (Index k = range.begin(); k != range.end() && k < best; ++k) {
            if (probe(k)) return k;
          }
          return best;
        },
        [](Index a, Index b) { return std::min(a, b); });
    return first < probes ? probe(first) : std::nullopt;
  }

 private:
  Box box(Index cell) const {
    Box b;
    for (int i = 0; i < c_.cellVertexCount(cell); ++i) b.extend(x_[c_.cellVertex(cell, i)]);
    return b;
  }

  std::optional<Overlap> probe(Index k) const {
    const Index cells = c_.cellCount();
    const bool centroid = k < cells;
    Vec3 p = Vec3::Zero();
    if (centroid) {
      const int n = c_.cellVertexCount(k);
      for (int i = 0; i < n; ++i) p += x_[c_.cellVertex(k, i)] / n;
      // The centroid of a very concave octahedron need not be its own.
      if (!inside(k, p)) return std::nullopt;
    } else {
      p = x_[k - cells];
    }
    std::optional<Overlap> found;
    bins_.visitAt(p, [&](Index cell) {
      if (centroid && cell == k) return false;
      if (!centroid && hasVertex(cell, k - cells)) return false;
      if (!inside(cell, p)) return false;
      const Index self = centroid ? k : cellAt(k - cells);
      if (self == kNone) return false;  // a vertex that no cell uses
      found = Overlap{self, cell};
      return true;
    });
    return found;
  }

  bool hasVertex(Index cell, Index v) const {
    for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
      if (c_.cellVertex(cell, i) == v) return true;
    }
    return false;
  }

  Index cellAt(Index v) const {
    Index first = kNone;
    c_.visitVertexStar(v, [&](const CellAtVertex& at) {
      if (first == kNone) first = at.cell;
    });
    return first;
  }

  /// Strictly inside: the cell's boundary winds once around the point, which is off every facet.
  bool inside(Index cell, const Vec3& p) const {
    const Box b = box(cell);
    if (!b.contains(p)) return false;
    const double margin = kInside * b.size().norm();
    const auto* facets = c_.isTet(cell) ? Tetrahedron::facets : Octahedron::facets;
    double angle = 0;
    for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
      const Vec3 a = x_[c_.cellVertex(cell, facets[k][0])] - p;
      const Vec3 e = x_[c_.cellVertex(cell, facets[k][1])] - p;
      const Vec3 f = x_[c_.cellVertex(cell, facets[k][2])] - p;
      const double volume = a.dot(e.cross(f));
      const Vec3 normal = (e - a).cross(f - a);
      if (std::abs(volume) <= margin * normal.norm() && c_.isTet(cell)) return false;
      const double la = a.norm(), le = e.norm(), lf = f.norm();
      if (la <= margin || le <= margin || lf <= margin) return false;
      const double solid =
          2 * std::atan2(volume, la * le * lf + a.dot(e) * lf + e.dot(f) * la + f.dot(a) * le);
      // On a facet the solid angle is half of a full turn.
      if (std::abs(volume) <= margin * normal.norm() && std::abs(solid) > 6.2) return false;
      angle += solid;
    }
    return std::abs(angle) > 6.3;  // 4 pi inside, 0 outside
  }

  const Complex& c_;
  const Array<Vec3>& x_;
  BoxBins bins_;
};

}  // namespace

std::optional<Overlap> findOverlap(const Complex& complex, const Array<Vec3>& positions) {
  return OverlapFinder(complex, positions).run();
}

}  // namespace octet
