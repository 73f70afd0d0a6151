// SPDX-License-Identifier: Apache-2.0
#include "constrained_minimum.h"

#include <vector>

#include "../base/error.h"

namespace octet {
namespace {

/// The perturbation that makes the system quasi-definite, relative to M's mean diagonal entry.
/// Between rounding (which the factors lose as 1e-16 / delta) and the square of the smallest
/// singular value of D, (mesh size / domain size)^2: refinement gains both factors per step.
constexpr double kDelta = 1e-7;
constexpr int kMostSteps = 20;
/// A step that lessens the residual by less than this was the last.
constexpr double kProgress = 0.5;

}  // namespace

ConstrainedMinimum::ConstrainedMinimum(Matrix mass, Matrix constraint, const Context& context)
    : mass_(std::move(mass)), constraint_(std::move(constraint)) {
  const Eigen::Index n = mass_.rows(), m = constraint_.rows();
  if (n > 0) scale_ = mass_.diagonal().mean();
  mass_ /= scale_;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(mass_.nonZeros() + constraint_.nonZeros() + m));
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Matrix::InnerIterator it(mass_, k); it; ++it) {
      if (it.row() >= it.col()) entries.emplace_back(it.row(), it.col(), it.value());
    }
    for (Matrix::InnerIterator it(constraint_, k); it; ++it) {
      entries.emplace_back(n + it.row(), it.col(), it.value());
    }
  }
  for (Eigen::Index k = 0; k < m; ++k) entries.emplace_back(n + k, n + k, -kDelta);
  Matrix system(n + m, n + m);
  system.setFromTriplets(entries.begin(), entries.end());
  context.poll();
  factors_.analyzePattern(system);
  context.poll();
  factors_.factorize(system);
  context.poll();
  if (factors_.info() != Eigen::Success || !factors_.vectorD().allFinite()) {
    throw InputError("", "the mesh has cells without volume: its mass matrix is singular");
  }
}

ConstrainedMinimum::Solution ConstrainedMinimum::solve(const Vector& pull, const Vector& right,
                                                       const Context& context) const {
  const Eigen::Index n = mass_.rows(), m = constraint_.rows();
  Vector x = Vector::Zero(n), forces = Vector::Zero(m), residual(n + m);
  const auto measure = [&] {
    residual.head(n) = pull / scale_ - mass_ * x - constraint_.transpose() * forces;
    residual.tail(m) = right - constraint_ * x;
    return residual.lpNorm<Eigen::Infinity>();
  };
  double size = measure();
  for (int step = 0; step < kMostSteps && size > 0; ++step) {
    context.poll();
    const Vector oldX = x, oldForces = forces;
    const Vector change = factors_.solve(residual);
    x += change.head(n);
    forces += change.tail(m);
    const double before = size;
    size = measure();
    if (size < kProgress * before) continue;
    if (size > before) {
      x = oldX;
      forces = oldForces;
    }
    break;
  }
  return {x, m > 0 ? (constraint_ * x - right).lpNorm<Eigen::Infinity>() : 0.0};
}

}  // namespace octet
