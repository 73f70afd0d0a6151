// SPDX-License-Identifier: Apache-2.0
#include "projection.h"

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

}  // namespace

template <int K>
struct ClosedProjection<K>::System {
  System(const Complex& complex, const Array<Vec3>& positions,
         const std::vector<std::uint8_t>& fixed)
      : derivative(coboundaryMatrix<K>(complex)),
        mass(massMatrix<K>(complex, positions)),
        free(complex.count(K), fixed),
        minimum(free.block(mass), free.columns(derivative)) {}

  Eigen::SparseMatrix<double> derivative, mass;
  FreeColumns free;
  ConstrainedMinimum minimum;
};

template <int K>
ClosedProjection<K>::ClosedProjection(const Complex& complex, const Array<Vec3>& positions,
                                      const std::vector<std::uint8_t>& fixed)
    : system_(std::make_unique<System>(complex, positions, fixed)) {}

template <int K>
ClosedProjection<K>::~ClosedProjection() = default;
template <int K>
ClosedProjection<K>::ClosedProjection(ClosedProjection&&) noexcept = default;

template <int K>
Cochain<K> ClosedProjection<K>::apply(const Cochain<K>& form, bool fixedToZero) const {
  const System& s = *system_;
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
  const auto solution = s.minimum.solve(pull, right);
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
Cochain<K> nearestClosed(const Complex& complex, const Array<Vec3>& positions,
                         const Cochain<K>& form, BoundaryRule rule) {
  const auto boundary =
      rule == BoundaryRule::Free ? std::vector<std::uint8_t>() : onBoundary<K>(complex);
  return ClosedProjection<K>(complex, positions, boundary).apply(form, rule == BoundaryRule::Zero);
}

template class ClosedProjection<1>;
template class ClosedProjection<2>;
template std::vector<std::uint8_t> onBoundary<0>(const Complex&);
template std::vector<std::uint8_t> onBoundary<1>(const Complex&);
template std::vector<std::uint8_t> onBoundary<2>(const Complex&);
template Cochain<1> nearestClosed(const Complex&, const Array<Vec3>&, const Cochain<1>&,
                                  BoundaryRule);
template Cochain<2> nearestClosed(const Complex&, const Array<Vec3>&, const Cochain<2>&,
                                  BoundaryRule);

}  // namespace octet
