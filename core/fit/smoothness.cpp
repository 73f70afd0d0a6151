// SPDX-License-Identifier: Apache-2.0
#include "smoothness.h"

#include "../hodge/coboundary_matrix.h"
#include "../hodge/mass_matrix.h"
#include "../topology/control_mesh.h"

namespace octet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Weight of the terms of lower order, `a` in the header: their share of the cost is at most this
/// where a field varies over l, yet far above rounding.
constexpr double kLowerOrder = 1e-3;

/// A diagonal entry is at least this share of the mass matrix' own.
constexpr double kLeastOfDiagonal = 0.2;

/// The measure of a simplex: its edge vector or area vector; 1 for a vertex, volume of a cell.
template <int K>
Eigen::MatrixX3d measures(const Complex& c, const Array<Vec3>& x) {
  Eigen::MatrixX3d result(c.count(K), 3);
  for (Index k = 0; k < c.count(K); ++k) {
    if constexpr (K == 1) {
      result.row(k) = x[c.edges[k][1]] - x[c.edges[k][0]];
    } else {
      const auto v = c.facetVertices(k);
      result.row(k) = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 2;
    }
  }
  return result;
}

/// Diagonal in place of a mass matrix: right for the constant field along each simplex.
template <int K>
Eigen::VectorXd lumped(const Complex& c, const Array<Vec3>& x, const Matrix& mass) {
  if constexpr (K == 0) {
    return mass * Eigen::VectorXd::Ones(c.count(0));
  } else if constexpr (K == 3) {
    return mass.diagonal();
  } else {
    const Eigen::MatrixX3d measure = measures<K>(c, x);
    const Eigen::MatrixX3d constants = mass * measure;
    const Eigen::VectorXd diagonal = mass.diagonal();
    Eigen::VectorXd result(c.count(K));
    for (Index k = 0; k < c.count(K); ++k) {
      const double exact = measure.row(k).dot(constants.row(k)) / measure.row(k).squaredNorm();
      result[k] = std::max(exact, kLeastOfDiagonal * diagonal[k]);
    }
    return result;
  }
}

/// 1 for each k-simplex none of whose vertices is on the boundary (deep), or that is itself not on
/// it.
template <int K>
Eigen::VectorXd inside(const Complex& c, bool deep) {
  Eigen::VectorXd result = Eigen::VectorXd::Ones(c.count(K));
  for (Index k = 0; k < c.count(K); ++k) {
    bool out = false;
    if constexpr (K == 0) {
      out = c.vertexOnBoundary(k);
    } else if constexpr (K == 1) {
      out = deep ? c.vertexOnBoundary(c.edges[k][0]) || c.vertexOnBoundary(c.edges[k][1])
                 : c.edgeOnBoundary(k);
    } else if constexpr (K == 2) {
      out = c.facetOnBoundary(k);
      if (deep) {
        for (const EdgeRef& e : c.facetEdges[k]) out |= c.edgeOnBoundary(e.index());
      }
    }
    if (out) result[k] = 0;
  }
  return result;
}

/// B' diag(w) B
Matrix squared(const Matrix& b, const Eigen::VectorXd& w) {
  const Matrix scaled = w.asDiagonal() * b;
  return Matrix(b.transpose()) * scaled;
}

struct Orders {
  Matrix first, second;  // |curl|^2 + |div|^2, |Laplacian|^2
};

/// Adds delta v, a (K-1)-form, and d delta v.
template <int K>
void addDown(const Complex& c, const Array<Vec3>& x, const Matrix& mass, Orders* orders) {
  const Matrix below = massMatrix<K - 1>(c, x);
  const Matrix d = coboundaryMatrix<K - 1>(c);
  const Eigen::VectorXd weights = lumped<K - 1>(c, x, below);
  const Eigen::VectorXd known = inside<K - 1>(c, false);
  const Matrix delta = Eigen::VectorXd(known.cwiseQuotient(weights)).asDiagonal() *
                       Matrix(Matrix(d.transpose()) * mass);
  orders->first += squared(delta, weights);
  const Eigen::VectorXd own = lumped<K>(c, x, mass).cwiseProduct(inside<K>(c, true));
  orders->second += squared(Matrix(d * delta), own);
}

/// Adds d v, a (K+1)-form, and delta d v.
template <int K>
void addUp(const Complex& c, const Array<Vec3>& x, const Matrix& mass, Orders* orders) {
  const Matrix above = massMatrix<K + 1>(c, x);
  const Matrix d = coboundaryMatrix<K>(c);
  orders->first += Matrix(d.transpose()) * Matrix(above * d);
  const Eigen::VectorXd weights = lumped<K>(c, x, mass);
  const Eigen::VectorXd known = inside<K>(c, false);
  const Matrix delta = Eigen::VectorXd(known.cwiseQuotient(weights)).asDiagonal() *
                       Matrix(Matrix(d.transpose()) * Matrix(above * d));
  orders->second += squared(delta, weights);
}

}  // namespace

double volumeOf(const Complex& complex, const Array<Vec3>& positions) {
  double volume = 0;
  for (Index cell = 0; cell < complex.cellCount(); ++cell) {
    volume += complex.cellSigns[cell] * cellVolume6(complex, positions, cell) / 6;
  }
  return volume;
}

template <int K>
Matrix smoothnessEnergy(const Complex& c, const Array<Vec3>& x, double length, bool curl,
                        bool divergence) {
  const Matrix mass = massMatrix<K>(c, x);
  Orders orders{Matrix(mass.rows(), mass.cols()), Matrix(mass.rows(), mass.cols())};
  // For a 2-form delta is the curl and d the divergence, for a 1-form the other way about.
  if (K == 2 ? curl : divergence) addDown<K>(c, x, mass, &orders);
  if (K == 2 ? divergence : curl) addUp<K>(c, x, mass, &orders);
  const double l2 = length * length;
  return (l2 * l2 * orders.second + kLowerOrder * l2 * orders.first +
          kLowerOrder * kLowerOrder * mass) /
         volumeOf(c, x);
}

template Matrix smoothnessEnergy<1>(const Complex&, const Array<Vec3>&, double, bool, bool);
template Matrix smoothnessEnergy<2>(const Complex&, const Array<Vec3>&, double, bool, bool);

Matrix gaugeEnergy(const Complex& c, const Array<Vec3>& x,
                   const std::vector<std::uint8_t>& vertices) {
  const Matrix d = coboundaryMatrix<0>(c);
  const Matrix divergence = Matrix(d.transpose()) * massMatrix<1>(c, x);
  Eigen::VectorXd weights = lumped<0>(c, x, massMatrix<0>(c, x)).cwiseInverse();
  for (Index v = 0; v < c.vertexCount(); ++v) weights[v] *= vertices[v];
  return squared(divergence, weights);
}

}  // namespace octet
