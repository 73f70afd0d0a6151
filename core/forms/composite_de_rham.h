// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "de_rham.h"

namespace octet {

/// @brief The de Rham map of a field that is known on voxels: simplices are cut into pieces no
/// longer than a voxel, and each piece is integrated with a rule that is exact for cubic (edges)
/// and quadratic (facets) fields. A trilinear field has kinks at voxel faces, which a single rule
/// of any order would miss.
class CompositeDeRham {
 public:
  /// @param pieceLength  longest piece, world units: the voxel size
  /// @param context  of one call: the map goes with it
  CompositeDeRham(const Complex& complex, const Array<Vec3>& positions, double pieceLength,
                  const Context& context = {})
      : c_(complex), x_(positions), length_(pieceLength), context_(context) {}

  /// @param v  Vec3(const Vec3&), called from many threads
  template <typename Function>
  Cochain<1> edges(const Function& v) const {
    const GaussRule rule(2);
    Cochain<1> result(c_);
    parallelFor<Index>(
        c_.edgeCount(),
        [&](Index e) {
          const Vec3& a = x_[c_.edges[e][0]];
          const Vec3 along = x_[c_.edges[e][1]] - a;
          const int n = pieces(along.norm());
          double sum = 0;
          for (int piece = 0; piece < n; ++piece) {
            for (std::size_t k = 0; k < 2; ++k) {
              sum += rule.weights[k] / n *
                     v(Vec3(a + (piece + rule.points[k]) / n * along)).dot(along);
            }
          }
          result[e] = sum;
        },
        context_, 16);
    return result;
  }

  template <typename Function>
  Cochain<2> facets(const Function& v) const {
    Cochain<2> result(c_);
    parallelFor<Index>(
        c_.facetCount(),
        [&](Index f) {
          const auto vertices = c_.facetVertices(f);
          const Vec3& a = x_[vertices[0]];
          const Vec3 p = x_[vertices[1]] - a, q = x_[vertices[2]] - a;
          const int n = pieces(std::max({p.norm(), q.norm(), (q - p).norm()}));
          const Vec3 area = p.cross(q) / 2;
          Vec3 sum = Vec3::Zero();
          for (int i = 0; i < n; ++i) {
            for (int j = 0; i + j < n; ++j) {
              sum += onTriangle(v, a, p / n, q / n, i, j, false);
              if (i + j + 1 < n) sum += onTriangle(v, a, p / n, q / n, i, j, true);
            }
          }
          result[f] = sum.dot(area) / (static_cast<double>(n) * n);
        },
        context_, 16);
    return result;
  }

 private:
  int pieces(double length) const {
    return std::max(1, static_cast<int>(std::ceil(length / length_)));
  }

  /// Mean of v over the small triangle (i,j), or the one upside down beside it: three inner points
  /// at 2/3, 1/6, 1/6, exact for quadratic fields.
  template <typename Function>
  static Vec3 onTriangle(const Function& v, const Vec3& a, const Vec3& p, const Vec3& q, int i,
                         int j, bool flipped) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      const double s = k == 1 ? 2.0 / 3 : 1.0 / 6, t = k == 2 ? 2.0 / 3 : 1.0 / 6;
      sum += v(Vec3(a + (i + (flipped ? 1 - s : s)) * p + (j + (flipped ? 1 - t : t)) * q));
    }
    return sum / 3;
  }

  const Complex& c_;
  const Array<Vec3>& x_;
  double length_;
  const Context context_;
};

}  // namespace octet
