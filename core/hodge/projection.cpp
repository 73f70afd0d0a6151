// SPDX-License-Identifier: Apache-2.0
#include "projection.h"

#include <numeric>

#include "../base/error.h"
#include "../forms/coboundary.h"
#include "coboundary_matrix.h"
#include "constrained_minimum.h"
#include "free_columns.h"
#include "mass_matrix.h"

namespace octet {
namespace {

/// What is left of d w', relative to the largest coefficient, when no closed form exists; rounding
/// is orders below.
constexpr double kNotClosed = 1e-9;

/// Connected parts of the boundary, as sets of its edges.
class BoundaryParts {
 public:
  explicit BoundaryParts(const Complex& complex) : parents_(complex.edges.size()) {
    std::iota(parents_.begin(), parents_.end(), Index{0});
    for (Index f = 0; f < complex.facetCount(); ++f) {
      if (!complex.facetOnBoundary(f)) continue;
      const auto& edges = complex.facetEdges[f];
      for (const EdgeRef& e : edges) parents_[root(e.index())] = root(edges[0].index());
    }
  }

  /// The edge that stands for the part of edge e.
  Index root(Index e) {
    while (parents_[e] != e) e = parents_[e] = parents_[parents_[e]];
    return e;
  }

 private:
  Array<Index> parents_;
};

/// 1 for each boundary facet on a part that is turned inside out: the wall of a cavity.
std::vector<std::uint8_t> cavityFacets(const Complex& complex, const Array<Vec3>& x) {
  BoundaryParts parts(complex);
  std::vector<double> volumes(complex.edges.size(), 0.0);
  const auto part = [&](Index f) { return parts.root(complex.facetEdges[f][0].index()); };
  for (Index f = 0; f < complex.facetCount(); ++f) {
    if (!complex.facetOnBoundary(f)) continue;
    const auto v = complex.facetVertices(f);
    const double volume6 = x[v[0]].dot(x[v[1]].cross(x[v[2]]));
    // The stored facet points out of the first of its cells.
    volumes[part(f)] += complex.facetCells[f][0].exists() ? volume6 : -volume6;
  }
  std::vector<std::uint8_t> result(static_cast<std::size_t>(complex.facetCount()));
  for (Index f = 0; f < complex.facetCount(); ++f) {
    result[f] = complex.facetOnBoundary(f) && volumes[part(f)] < 0;
  }
  return result;
}

/// 1 for each k-simplex of the facets.
template <int K>
std::vector<std::uint8_t> ofFacets(const Complex& complex,
                                   const std::vector<std::uint8_t>& facets) {
  if constexpr (K == 2) return facets;
  std::vector<std::uint8_t> result(static_cast<std::size_t>(complex.count(K)));
  for (Index f = 0; f < complex.facetCount(); ++f) {
    if (!facets[f]) continue;
    for (const EdgeRef& e : complex.facetEdges[f]) result[e.index()] = 1;
  }
  return result;
}

}  // namespace

template <int K>
struct ClosedProjection<K>::System {
  System(const Complex& complex, const Array<Vec3>& positions,
         const std::vector<std::uint8_t>& fixed, const Context& context)
      : numbering(complex),
        derivative(coboundaryMatrix<K>(complex)),
        mass(massMatrix<K>(complex, positions)),
        free(complex.count(K), fixed),
        minimum(free.block(mass), free.columns(derivative), context) {}

  Numbering numbering;
  Eigen::SparseMatrix<double> derivative, mass;
  FreeColumns free;
  ConstrainedMinimum minimum;
};

template <int K>
ClosedProjection<K>::ClosedProjection(const Complex& complex, const Array<Vec3>& positions,
                                      const std::vector<std::uint8_t>& fixed,
                                      const Context& context)
    : system_(std::make_unique<System>(complex, positions, fixed, context)) {}

template <int K>
ClosedProjection<K>::~ClosedProjection() = default;
template <int K>
ClosedProjection<K>::ClosedProjection(ClosedProjection&&) noexcept = default;

template <int K>
Cochain<K> ClosedProjection<K>::apply(const Cochain<K>& form, bool fixedToZero,
                                      const Context& context) const {
  const System& s = *system_;
  form.checkOn(static_cast<Index>(s.mass.rows()), s.numbering);
  Cochain<K> result = form;
  if (fixedToZero) s.free.clearOthers(result.data());
  const auto vector = [](const Cochain<K>& x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
  };
  // The fixed coefficients have moved already, by z; move the free ones by u so that the energy of
  // u + z is least and d u = -d(w + z).
  const Eigen::VectorXd moved = vector(result) - vector(form);
  const Eigen::VectorXd pull = -s.free.rows(s.mass * moved),
                        right = -(s.derivative * vector(result));
  const auto solution = s.minimum.solve(pull, right, context);
  const double scale = maxNorm(form.values());
  if (solution.residual > kNotClosed * scale) {
    throw InputError("", "no closed form has these boundary coefficients: a net " +
                             std::string(K == 2 ? "flux through" : "circulation around") +
                             " the boundary is left over");
  }
  s.free.add(solution.x, result.data());
  return result;
}

template <int K>
std::vector<std::uint8_t> onBoundary(const Complex& complex) {
  std::vector<std::uint8_t> result(complex.count(K));
  for (Index k = 0; k < complex.count(K); ++k) {
    if constexpr (K == 0) result[k] = complex.vertexOnBoundary(k);
    if constexpr (K == 1) result[k] = complex.edgeOnBoundary(k);
    if constexpr (K == 2) result[k] = complex.facetOnBoundary(k);
  }
  return result;
}

template <int K>
std::vector<std::uint8_t> fixedBy(BoundaryRule rule, const Complex& complex,
                                  const Array<Vec3>& positions) {
  if (rule == BoundaryRule::Free) return {};
  if (rule == BoundaryRule::ZeroInside) {
    return ofFacets<K>(complex, cavityFacets(complex, positions));
  }
  return onBoundary<K>(complex);
}

template <int K>
Cochain<K> nearestClosed(const Complex& complex, const Array<Vec3>& positions,
                         const Cochain<K>& form, BoundaryRule rule, const Context& context) {
  return ClosedProjection<K>(complex, positions, fixedBy<K>(rule, complex, positions), context)
      .apply(form, fixesToZero(rule), context);
}

template class ClosedProjection<1>;
template class ClosedProjection<2>;
template std::vector<std::uint8_t> onBoundary<0>(const Complex&);
template std::vector<std::uint8_t> onBoundary<1>(const Complex&);
template std::vector<std::uint8_t> onBoundary<2>(const Complex&);
template std::vector<std::uint8_t> fixedBy<1>(BoundaryRule, const Complex&, const Array<Vec3>&);
template std::vector<std::uint8_t> fixedBy<2>(BoundaryRule, const Complex&, const Array<Vec3>&);
template Cochain<1> nearestClosed(const Complex&, const Array<Vec3>&, const Cochain<1>&,
                                  BoundaryRule, const Context&);
template Cochain<2> nearestClosed(const Complex&, const Array<Vec3>&, const Cochain<2>&,
                                  BoundaryRule, const Context&);

}  // namespace octet
