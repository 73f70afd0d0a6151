// SPDX-License-Identifier: Apache-2.0
#include "star.h"

#include <Eigen/Dense>
#include <algorithm>
#include <complex>
#include <tuple>

#include "cell_kernels.h"

namespace octet {
namespace {

/// @brief Fills the rows of a star's matrix: linear subdivision less D1 d0, cell by cell.
class StarMatrixBuilder {
 public:
  explicit StarMatrixBuilder(const Star& star)
      : star_(star),
        kernels_(kDefaultZeta),
        matrix_(Eigen::MatrixXd::Zero(star.vertexCount, star.vertexCount)) {}

  void addRow(int label) {
    if (label == 0) {
      addCentre();
    } else if (const std::vector<int> cells = cellsAtEdge(star_, label); !cells.empty()) {
      addMidpoint(label, cells);
    } else {
      addOpposite(label);
    }
  }
  Eigen::MatrixXd take() { return std::move(matrix_); }

 private:
  void addCentre() {
    matrix_(0, 0) = 1;
    const double share = 1.0 / star_.cellCount();
    for (const auto& tet : star_.tets) addMean(kernels_.tet, tet, 0, share, 0);
    for (const auto& oct : star_.octs) addMean(kernels_.oct, oct, 0, share, 0);
  }

  void addMidpoint(int label, const std::vector<int>& cells) {
    matrix_(label, 0) = matrix_(label, label) = 0.5;
    // Fine cells at a midpoint: two corner children of each cell, and those between.
    int fineCells = 0;
    for (const int cell : cells) fineCells += star_.isTet(cell) ? 3 : 4;
    const auto add = [&](auto shape, const auto& kernel, const auto& corners) {
      using Shape = decltype(shape);
      const auto place = [&](int wanted) {
        return std::find(corners.begin(), corners.end(), wanted) - corners.begin();
      };
      const int edge = kCellTables<Shape>.edgeBetween[place(0)][place(label)];
      addMean(kernel, corners, FineVertices<Shape>::midpoint(edge), 1.0 / fineCells, label);
    };
    for (const int cell : cells) {
      if (star_.isTet(cell)) {
        add(Tetrahedron{}, kernels_.tet, star_.tets[cell]);
      } else {
        add(Octahedron{}, kernels_.oct, star_.oct(cell));
      }
    }
  }

  /// The centre of the octahedron; 14 fine cells meet there.
  void addOpposite(int label) {
    for (const auto& oct : star_.octs) {
      if (oct[5] != label) continue;
      for (const int corner : oct) matrix_(label, corner) = 1.0 / 6;
      addMean(kernels_.oct, oct, FineVertices<Octahedron>::kCount - 1, 1.0 / 14, label);
      return;
    }
  }

  /// Subtracts the cell's part of D1 d0, times `weight`.
  template <typename Shape, typename Corners>
  void addMean(const CellKernel<Shape>& kernel, const Corners& corners, int fineVertex,
               double weight, int row) {
    for (int k = 0; k < Shape::kEdges; ++k) {
      const double w = weight * kernel.vertexHomotopy[k][fineVertex];
      matrix_(row, corners[Shape::edges[k][1]]) -= w;
      matrix_(row, corners[Shape::edges[k][0]]) += w;
    }
  }

  const Star& star_;
  CellKernels kernels_;
  Eigen::MatrixXd matrix_;
};

}  // namespace

bool Star::operator<(const Star& other) const {
  return std::tie(vertexCount, tets, octs) < std::tie(other.vertexCount, other.tets, other.octs);
}

std::vector<int> cellsAtEdge(const Star& star, int label) {
  std::vector<int> cells;
  for (int cell = 0; cell < star.cellCount(); ++cell) {
    const bool has = star.isTet(cell)
                         ? std::count(star.tets[cell].begin(), star.tets[cell].end(), label) > 0
                         : std::count(star.oct(cell).begin(), star.oct(cell).end() - 1, label) > 0;
    if (has) cells.push_back(cell);
  }
  return cells;
}

bool adjacentToCentre(const Star& star, int label) {
  return label != 0 && !cellsAtEdge(star, label).empty();
}

Eigen::MatrixXd starMatrix(const Star& star, int first) {
  StarMatrixBuilder builder(star);
  for (int label = first; label < star.vertexCount; ++label) builder.addRow(label);
  return builder.take();
}

Eigen::VectorXd limitWeights(const Eigen::MatrixXd& matrix) {
  const Eigen::Index n = matrix.rows();
  Eigen::MatrixXd equations(n + 1, n);
  equations.topRows(n) = matrix.transpose() - Eigen::MatrixXd::Identity(n, n);
  equations.row(n).setOnes();
  return equations.colPivHouseholderQr().solve(Eigen::VectorXd::Unit(n + 1, n));
}

Eigen::MatrixXd invariantSubspace(const Eigen::MatrixXd& matrix, double above) {
  const Eigen::EigenSolver<Eigen::MatrixXd> eigen(matrix);
  std::vector<Eigen::VectorXd> columns;
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    const std::complex<double> value = eigen.eigenvalues()[k];
    if (std::abs(value) <= above || value.imag() < 0) continue;
    columns.push_back(eigen.eigenvectors().col(k).real());
    if (value.imag() > 0) columns.push_back(eigen.eigenvectors().col(k).imag());
  }
  Eigen::MatrixXd basis(matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index k = 0; k < basis.cols(); ++k) {
    basis.col(k) = columns[static_cast<std::size_t>(k)].normalized();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(basis);
  return qr.householderQ() * Eigen::MatrixXd::Identity(basis.rows(), basis.cols());
}

}  // namespace octet
