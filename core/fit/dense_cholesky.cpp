// SPDX-License-Identifier: Apache-2.0
#include "dense_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "../base/reported_loop.h"

namespace octet {
namespace {

constexpr Eigen::Index kBlock = 128;

}  // namespace

DenseCholesky::DenseCholesky(Eigen::MatrixXd matrix, const Context& context)
    : factor_(std::move(matrix)) {
  const Eigen::Index n = factor_.rows();
  for (Eigen::Index k = 0; k < n; k += kBlock) {
    context.poll();
    const Eigen::Index size = std::min(kBlock, n - k), next = k + size;
    auto diagonal = factor_.block(k, k, size, size);
    Eigen::Ref<Eigen::MatrixXd> block = diagonal;
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(block);
    if (factors.info() != Eigen::Success) {
      succeeded_ = false;
      return;
    }
    const Eigen::Index blocks = (n - next + kBlock - 1) / kBlock;
    const auto rows = [&](Eigen::Index b) { return std::min(kBlock, n - next - b * kBlock); };
    parallelFor<Eigen::Index>(
        blocks,
        [&](Eigen::Index b) {
          auto below = factor_.block(next + b * kBlock, k, rows(b), size);
          diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
              below);
        },
        context, 1);
    parallelFor<Eigen::Index>(
        blocks,
        [&](Eigen::Index b) {
          const Eigen::Index at = next + b * kBlock;
          factor_.block(at, at, n - at, rows(b)).noalias() -=
              factor_.block(at, k, n - at, size) * factor_.block(at, k, rows(b), size).transpose();
        },
        context, 1);
  }
}

double DenseCholesky::smallestPivot() const {
  return factor_.rows() > 0 ? factor_.diagonal().cwiseAbs2().minCoeff() : 1;
}

Eigen::VectorXd DenseCholesky::solve(const Eigen::VectorXd& right) const {
  Eigen::VectorXd x = factor_.triangularView<Eigen::Lower>().solve(right);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

}  // namespace octet
