// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/parallel.h"
#include "cochain.h"

namespace octet {

/// Points and weights of Gauss-Legendre quadrature on [0, 1]; exact for polynomials of degree
/// 2 n - 1.
struct GaussRule {
  explicit GaussRule(int n);
  std::vector<double> points, weights;
};

/// @brief The de Rham map (thesis 3.1.2): integrates a field over the simplices of a level.
///
/// Edges get the line integral of a vector field along them, facets the flux through them in the
/// direction of their stored orientation, cells the integral of a density, vertices the value.
/// Facets are flat triangles; an octahedron is what its eight facets enclose.
class DeRham {
 public:
  /// @param order  polynomials of this degree are integrated exactly, 0 to 40
  DeRham(const Complex& complex, const Array<Vec3>& positions, int order);

  /// @param f  double(const Vec3&), called from many threads
  template <typename Function>
  Cochain<0> vertices(const Function& f) const;
  /// @param v  Vec3(const Vec3&)
  template <typename Function>
  Cochain<1> edges(const Function& v) const;
  template <typename Function>
  Cochain<2> facets(const Function& v) const;
  /// @param density  double(const Vec3&)
  template <typename Function>
  Cochain<3> cells(const Function& density) const;

 private:
  const Complex& c_;
  const Array<Vec3>& x_;
  GaussRule onEdge_;
  // On the unit triangle and the unit tetrahedron: barycentric coordinates and weights.
  std::vector<std::array<double, 4>> onFacet_, inTet_;
};

template <typename Function>
Cochain<0> DeRham::vertices(const Function& f) const {
  Cochain<0> result(c_);
  parallelFor<Index>(c_.vertexCount(), [&](Index v) { result[v] = f(x_[v]); });
  return result;
}

template <typename Function>
Cochain<1> DeRham::edges(const Function& v) const {
  Cochain<1> result(c_);
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    const Vec3& a = x_[c_.edges[e][0]];
    const Vec3 along = x_[c_.edges[e][1]] - a;
    double sum = 0;
    for (std::size_t k = 0; k < onEdge_.points.size(); ++k) {
      const Vec3 value = v(Vec3(a + onEdge_.points[k] * along));
      sum += onEdge_.weights[k] * value.dot(along);
    }
    result[e] = sum;
  });
  return result;
}

template <typename Function>
Cochain<2> DeRham::facets(const Function& v) const {
  Cochain<2> result(c_);
  parallelFor<Index>(c_.facetCount(), [&](Index f) {
    const auto vertices = c_.facetVertices(f);
    const Vec3 &a = x_[vertices[0]], &b = x_[vertices[1]], &c = x_[vertices[2]];
    const Vec3 area = (b - a).cross(c - a) / 2;
    double sum = 0;
    for (const auto& [u, s, t, w] : onFacet_) {
      const Vec3 value = v(Vec3(u * a + s * b + t * c));
      sum += w * value.dot(area);
    }
    result[f] = sum;
  });
  return result;
}

template <typename Function>
Cochain<3> DeRham::cells(const Function& density) const {
  Cochain<3> result(c_);
  parallelFor<Index>(c_.cellCount(), [&](Index cell) {
    const int n = c_.cellVertexCount(cell);
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < n; ++i) centre += x_[c_.cellVertex(cell, i)] / n;
    // Tetrahedra over the outward facets, seen from the centroid.
    const auto* facets = c_.isTet(cell) ? Tetrahedron::facets : Octahedron::facets;
    double sum = 0;
    for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
      const Vec3 a = x_[c_.cellVertex(cell, facets[k][0])] - centre;
      const Vec3 b = x_[c_.cellVertex(cell, facets[k][1])] - centre;
      const Vec3 c = x_[c_.cellVertex(cell, facets[k][2])] - centre;
      const double volume = c_.cellSigns[cell] * a.dot(b.cross(c)) / 6;
      for (const auto& [u, s, t, w] : inTet_) {
        sum += w * volume * density(Vec3(centre + u * a + s * b + t * c));
      }
    }
    result[cell] = sum;
  });
  return result;
}

}  // namespace octet
