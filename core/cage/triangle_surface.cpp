// SPDX-License-Identifier: Apache-2.0
#include "triangle_surface.h"

#include <algorithm>
#include <tuple>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include "../base/error.h"

namespace octet {
namespace {

using Triangle = std::array<Index, 3>;

/// Coordinates beyond this overflow when multiplied, as in a control mesh.
constexpr double kLargestCoordinate = 1e30;
/// Depth, relative to the triangles' size, below which a crossing is rounding.
constexpr double kDepth = 1e-9;

std::string place(const char* list, Index k) {
  return std::string(list) + "[" + std::to_string(k) + "]";
}

Box boxOf(const TriangleSurface& s, Index t) {
  Box box;
  for (const Index v : s.triangles[t]) box.extend(s.vertices[v]);
  return box;
}

std::vector<Box> boxesOf(const TriangleSurface& s) {
  std::vector<Box> boxes(s.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) boxes[t] = boxOf(s, static_cast<Index>(t));
  return boxes;
}

/// Nearest point of a triangle: in its vertices' and edges' Voronoi regions, else in its plane.
/// (C. Ericson, Real-Time Collision Detection, 5.1.5.)
Vec3 closestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double sum = va + vb + vc;
  return sum > 0 ? Vec3(a + (vb / sum) * ab + (vc / sum) * ac) : a;
}

double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).dot((c - a).cross(d - a));
}

/// Does a segment pass through the inside of a triangle, its ends on either side?
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c,
             double depth) {
  const double area2 = (b - a).cross(c - a).norm(), length = (q - p).norm();
  const double above = volume6(a, b, c, p), below = volume6(a, b, c, q);
  if (std::abs(above) <= depth * area2 || std::abs(below) <= depth * area2) return false;
  if ((above > 0) == (below > 0)) return false;
  // On the same side of the segment seen along all three edges, and not just touching one.
  const double limit = depth * length * std::sqrt(area2);
  const double u = volume6(p, q, a, b), v = volume6(p, q, b, c), w = volume6(p, q, c, a);
  return (u > limit && v > limit && w > limit) || (u < -limit && v < -limit && w < -limit);
}

class IntersectionFinder {
 public:
  explicit IntersectionFinder(const TriangleSurface& surface)
      : s_(surface), tree_(boxesOf(surface)) {}

  std::optional<Intersection> run() const {
    // The lowest triangle that meets an earlier one, so that it does not depend on threads.
    const Index count = static_cast<Index>(s_.triangles.size());
    const Index first = tbb::parallel_reduce(
        tbb::blocked_range<Index>(0, count, 256), count,
        [&](const tbb::blocked_range<Index>& range, Index best) {
          for (Index t = range.begin(); t != range.end() && t < best; ++t) {
            if (earlier(t) != kNone) return t;
          }
          return best;
        },
        [](Index a, Index b) { return std::min(a, b); });
    if (first == count) return std::nullopt;
    return Intersection{first, earlier(first)};
  }

 private:
  Index earlier(Index t) const {
    Index found = kNone;
    tree_.visitTouching(tree_.box(t), [&](Index other) {
      if (other >= t || (found != kNone && other > found)) return;
      if (intersect(s_.triangles[t], s_.triangles[other])) found = other;
    });
    return found;
  }

  const Vec3& at(Index v) const { return s_.vertices[v]; }

  bool intersect(const Triangle& t, const Triangle& u) const {
    int shared = 0;
    for (const Index v : t) shared += std::count(u.begin(), u.end(), v) > 0;
    if (shared == 3) return true;
    const double depth = kDepth * (size(t) + size(u)) / 2;
    if (shared == 2) return foldedOver(t, u);
    return edgeCrosses(t, u, depth) || edgeCrosses(u, t, depth);
  }

  double size(const Triangle& t) const {
    return (at(t[1]) - at(t[0])).norm() + (at(t[2]) - at(t[0])).norm();
  }

  bool edgeCrosses(const Triangle& edges, const Triangle& t, double depth) const {
    for (int k = 0; k < 3; ++k) {
      if (crosses(at(edges[k]), at(edges[(k + 1) % 3]), at(t[0]), at(t[1]), at(t[2]), depth)) {
        return true;
      }
    }
    return false;
  }

  /// Neighbours in one plane on the same side of the edge they share.
  bool foldedOver(const Triangle& t, const Triangle& u) const {
    const auto third = [&](const Triangle& from, const Triangle& other) {
      for (const Index v : from) {
        if (std::count(other.begin(), other.end(), v) == 0) return v;
      }
      return from[0];
    };
    const Index p = third(t, u), q = third(u, t);
    Index edge[2];
    int n = 0;
    for (const Index v : t) {
      if (v != p) edge[n++] = v;
    }
    const Vec3 along = at(edge[1]) - at(edge[0]);
    const Vec3 a = along.cross(at(p) - at(edge[0])), b = along.cross(at(q) - at(edge[0]));
    return a.dot(b) > 0 && a.cross(b).norm() <= kDepth * a.norm() * b.norm();
  }

  const TriangleSurface& s_;
  BoxTree tree_;
};

}  // namespace

Box TriangleSurface::bounds() const {
  Box box;
  for (const Vec3& p : vertices) box.extend(p);
  return box;
}

double TriangleSurface::volume() const {
  if (vertices.empty()) return 0;
  const Vec3 origin = vertices[0];
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    sum += (vertices[a] - origin).dot((vertices[b] - origin).cross(vertices[c] - origin));
  }
  return sum / 6;
}

TriangleSurface boxSurface(const Box& box) {
  if (box.empty() || !box.size().allFinite() || !(box.size().minCoeff() > 0)) {
    throw InputError("box", "is empty or not finite");
  }
  TriangleSurface surface;
  for (int k = 0; k < 8; ++k) {
    const auto side = [&](int axis) { return (k >> axis & 1 ? box.max : box.min)[axis]; };
    surface.vertices.emplace_back(side(0), side(1), side(2));
  }
  constexpr Index kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& [a, b, c, d] : kSides) {
    surface.triangles.push_back({a, b, c});
    surface.triangles.push_back({a, c, d});
  }
  return surface;
}

ClosestPoints::ClosestPoints(const TriangleSurface& surface)
    : surface_(surface), tree_(boxesOf(surface)) {}

SurfacePoint ClosestPoints::find(const Vec3& p) const {
  const auto closest = [&](Index t) {
    const auto& [a, b, c] = surface_.triangles[t];
    return closestOnTriangle(p, surface_.vertices[a], surface_.vertices[b], surface_.vertices[c]);
  };
  const auto [triangle, distance2] =
      tree_.nearest(p, [&](Index t) { return (closest(t) - p).squaredNorm(); });
  if (triangle == kNone) return {p, kNone, HUGE_VAL};
  return {closest(triangle), triangle, std::sqrt(distance2)};
}

void checkClosed(const TriangleSurface& surface) {
  if (surface.triangles.empty()) throw InputError("", "the surface has no triangles");
  const Index n = static_cast<Index>(surface.vertices.size());
  for (Index v = 0; v < n; ++v) {
    const Vec3& p = surface.vertices[v];
    if (!p.allFinite()) throw InputError(place("vertices", v), "coordinate is not a finite number");
    if (p.cwiseAbs().maxCoeff() > kLargestCoordinate) {
      throw InputError(place("vertices", v), "coordinate is larger than 1e30");
    }
  }
  std::vector<std::tuple<Index, Index, Index>> edges;
  edges.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& triangle = surface.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const Index a = triangle[k], b = triangle[(k + 1) % 3];
      if (a < 0 || a >= n) {
        throw InputError(place("triangles", static_cast<Index>(t)),
                         "vertex " + std::to_string(a) + " is out of range, there are " +
                             std::to_string(n) + " vertices");
      }
      if (a == b) {
        throw InputError(place("triangles", static_cast<Index>(t)),
                         "vertex " + std::to_string(a) + " is repeated");
      }
      edges.emplace_back(std::min(a, b), std::max(a, b), static_cast<Index>(t));
    }
  }
  tbb::parallel_sort(edges.begin(), edges.end());
  for (std::size_t k = 0; k < edges.size();) {
    const auto [a, b, t] = edges[k];
    std::size_t end = k;
    while (end < edges.size() && std::get<0>(edges[end]) == a && std::get<1>(edges[end]) == b)
      ++end;
    if ((end - k) % 2 != 0) {
      throw InputError(place("triangles", t), "the surface is not closed: edge (" +
                                                  std::to_string(a) + "," + std::to_string(b) +
                                                  ") has " + std::to_string(end - k) +
                                                  (end - k == 1 ? " triangle" : " triangles"));
    }
    k = end;
  }
}

std::optional<Intersection> findSelfIntersection(const TriangleSurface& surface) {
  return IntersectionFinder(surface).run();
}

TriangleSurface welded(const TriangleSurface& surface) {
  const Index n = static_cast<Index>(surface.vertices.size());
  const auto key = [&](Index v) {
    const Vec3& p = surface.vertices[v];
    return std::make_tuple(p[0], p[1], p[2]);
  };
  std::vector<Index> order(surface.vertices.size());
  for (Index v = 0; v < n; ++v) order[v] = v;
  tbb::parallel_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return std::make_tuple(key(a), a) < std::make_tuple(key(b), b);
  });
  std::vector<Index> first(surface.vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  TriangleSurface result;
  std::vector<Index> number(surface.vertices.size(), kNone);
  for (const Triangle& t : surface.triangles) {
    Triangle kept = {first[t[0]], first[t[1]], first[t[2]]};
    if (kept[0] == kept[1] || kept[1] == kept[2] || kept[0] == kept[2]) continue;
    for (Index& v : kept) {
      if (number[v] == kNone) {
        number[v] = static_cast<Index>(result.vertices.size());
        result.vertices.push_back(surface.vertices[v]);
      }
      v = number[v];
    }
    result.triangles.push_back(kept);
  }
  return result;
}

}  // namespace octet
