// SPDX-License-Identifier: Apache-2.0
#include "least_squares.h"

#include <Eigen/IterativeLinearSolvers>
#include <limits>

#include "../base/reported_loop.h"
#include "dense_cholesky.h"

namespace octet {
namespace {

/// Of the normal equations, at which conjugate gradients are done.
constexpr double kIterativeTolerance = 1e-9;
constexpr int kMostIterations = 4000;

/// A scaled pivot below this is rounding: that direction is not determined.
constexpr double kSmallestPivot = 1e-13;

using Vector = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

/// Which rows have an unknown, and with what weight.
struct Column {
  std::vector<std::size_t> row;
  std::vector<double> weight;
};

class NormalEquations {
 public:
  explicit NormalEquations(const LeastSquares& problem) : p_(problem), n_(p_.energy->rows()) {
    columns_.resize(static_cast<std::size_t>(n_));
    for (std::size_t r = 0; r < p_.rows.size(); ++r) {
      for (std::size_t k = 0; k < p_.rows[r].size(); ++k) {
        Column& column = columns_[static_cast<std::size_t>(p_.rows[r].index[k])];
        column.row.push_back(r);
        column.weight.push_back(p_.rows[r].weight[k]);
      }
    }
    scale_ = p_.energy->diagonal();
    for (Eigen::Index k = 0; k < n_; ++k) {
      const Column& column = columns_[static_cast<std::size_t>(k)];
      for (std::size_t j = 0; j < column.row.size(); ++j) {
        scale_[k] += p_.weights[column.row[j]] * column.weight[j] * column.weight[j];
      }
      scale_[k] = scale_[k] > 0 ? 1 / std::sqrt(scale_[k]) : 1;
    }
  }

  Eigen::Index size() const { return n_; }
  /// Factors that give the matrix a diagonal of 1.
  const Vector& scale() const { return scale_; }

  /// Calls `add(row, term)` for the terms of column k of the scaled matrix.
  template <typename Add>
  void column(Eigen::Index k, const Add& add) const {
    const Column& entries = columns_[static_cast<std::size_t>(k)];
    for (std::size_t j = 0; j < entries.row.size(); ++j) {
      const SparseRow& row = p_.rows[entries.row[j]];
      const double w = p_.weights[entries.row[j]] * entries.weight[j] * scale_[k];
      for (std::size_t i = 0; i < row.size(); ++i) {
        add(row.index[i], w * row.weight[i] * scale_[row.index[i]]);
      }
    }
    for (Sparse::InnerIterator it(*p_.energy, k); it; ++it) {
      add(static_cast<Index>(it.row()), it.value() * scale_[k] * scale_[it.row()]);
    }
  }

  /// Right side minus matrix times x, in unscaled unknowns, by the original rows.
  Vector residual(const Vector& x) const {
    std::vector<double> misses(p_.rows.size());
    parallelFor<std::size_t>(p_.rows.size(), [&](std::size_t r) {
      misses[r] = p_.weights[r] * (p_.rights[r] - p_.rows[r].apply(x.data()));
    });
    Vector result = -(*p_.energy * x);
    if (p_.energyPull.size() > 0) result += p_.energyPull;
    parallelFor<Eigen::Index>(n_, [&](Eigen::Index k) {
      const Column& column = columns_[static_cast<std::size_t>(k)];
      double sum = 0;
      for (std::size_t j = 0; j < column.row.size(); ++j) {
        sum += column.weight[j] * misses[column.row[j]];
      }
      result[k] += sum;
    });
    return result;
  }

 private:
  const LeastSquares& p_;
  Eigen::Index n_;
  std::vector<Column> columns_;
  Vector scale_;
};

/// Applies `step` to residuals until they are at `enough` or do not shrink any more.
template <typename Step>
void refine(const NormalEquations& equations, const Step& step, double enough,
            LeastSquaresSolution* solution) {
  const Vector zero = Vector::Zero(equations.size());
  Vector residual = equations.residual(zero);
  const double scale = equations.scale().cwiseProduct(residual).norm();
  solution->x = zero;
  solution->residual = scale > 0 ? 1 : 0;
  constexpr int kMostSteps = 4;
  for (int k = 0; k < kMostSteps && solution->residual > enough; ++k) {
    const Vector next = solution->x + step(residual);
    residual = equations.residual(next);
    const double left = equations.scale().cwiseProduct(residual).norm() / scale;
    if (!(left < solution->residual)) return;
    const bool done = left > solution->residual / 10;
    solution->x = next;
    solution->residual = left;
    if (done) return;
  }
}

LeastSquaresSolution solveDirectly(const NormalEquations& equations, const Context& context) {
  const double n = static_cast<double>(equations.size());
  const MemoryReservation memory = context.reserve(n * n * sizeof(double), "normal equations");
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(equations.size(), equations.size());
  parallelFor<Eigen::Index>(
      equations.size(),
      [&](Eigen::Index k) {
        double* const column = matrix.col(k).data();
        equations.column(k, [&](Index i, double w) { column[i] += w; });
      },
      context, 8);
  const DenseCholesky factors(std::move(matrix), context);
  LeastSquaresSolution solution;
  solution.determined = factors.succeeded() && factors.smallestPivot() > kSmallestPivot;
  if (!factors.succeeded()) {
    solution.x = Vector::Zero(equations.size());
    solution.residual = 1;
    return solution;
  }
  const Vector& scale = equations.scale();
  const auto step = [&](const Vector& r) -> Vector {
    return scale.cwiseProduct(factors.solve(scale.cwiseProduct(r)));
  };
  refine(equations, step, 0, &solution);
  return solution;
}

Sparse assemble(const NormalEquations& equations, const Context& context) {
  const Eigen::Index n = equations.size();
  std::vector<SparseRow> columns(static_cast<std::size_t>(n));
  parallelRanges<Eigen::Index>(
      n,
      [&](Eigen::Index first, Eigen::Index last) {
        RowSum sum(static_cast<Index>(n));
        for (Eigen::Index k = first; k < last; ++k) {
          equations.column(k, [&](Index i, double w) { sum.add(i, w); });
          columns[static_cast<std::size_t>(k)] = sum.take();
        }
      },
      context, 256);
  Sparse matrix(n, n);
  Eigen::VectorXi sizes(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    sizes[k] = static_cast<int>(columns[static_cast<std::size_t>(k)].size());
  }
  matrix.reserve(sizes);
  for (Eigen::Index k = 0; k < n; ++k) {
    const SparseRow& column = columns[static_cast<std::size_t>(k)];
    for (std::size_t j = 0; j < column.size(); ++j) {
      matrix.insert(column.index[j], k) = column.weight[j];
    }
  }
  matrix.makeCompressed();
  return matrix;
}

LeastSquaresSolution solveIteratively(const NormalEquations& equations, const Context& context) {
  const Sparse matrix = assemble(equations, context);
  Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper, Eigen::IncompleteCholesky<double>>
      gradients;
  // Half of it, as that is measured on the original rows.
  gradients.setTolerance(kIterativeTolerance / 2);
  gradients.setMaxIterations(kMostIterations);
  context.poll();
  gradients.compute(matrix);
  LeastSquaresSolution solution;
  solution.direct = false;
  const Vector& scale = equations.scale();
  const auto step = [&](const Vector& r) -> Vector {
    const Vector x = gradients.solve(scale.cwiseProduct(r));
    solution.iterations += static_cast<int>(gradients.iterations());
    return scale.cwiseProduct(x);
  };
  refine(equations, step, kIterativeTolerance, &solution);
  solution.determined = solution.residual < std::sqrt(kIterativeTolerance);
  return solution;
}

}  // namespace

LeastSquaresSolution solve(const LeastSquares& problem, const Context& context) {
  const NormalEquations equations(problem);
  const std::size_t n = static_cast<std::size_t>(equations.size());
  context.report({"solve", 0, n, "unknowns"});
  LeastSquaresSolution solution = equations.size() <= problem.mostDirect
                                      ? solveDirectly(equations, context)
                                      : solveIteratively(equations, context);
  context.report({"solve", n, n, "unknowns"});
  return solution;
}

}  // namespace octet
