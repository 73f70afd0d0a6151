// SPDX-License-Identifier: Apache-2.0
#include "smoothness.h"

#include "../hodge/coboundary_matrix.h"
#include "../hodge/mass_matrix.h"
#include "../topology/control_mesh.h"

namespace octet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Weights `a` and `b` of the terms of lower order in the header. Below a = 0.01 speed grows
/// between guides and walls, to twice that of rings in a box and more; above 1 guides are missed by
/// more.
constexpr double kFirstOrder = 0.1, kZerothOrder = 1e-6;

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

/// |d delta v|^2, of a (K-1)-form delta v.
template <int K>
Matrix downAndUp(const Complex& c, const Array<Vec3>& x, const Matrix& mass) {
  const Matrix below = massMatrix<K - 1>(c, x);
  const Matrix d = coboundaryMatrix<K - 1>(c);
  const Eigen::VectorXd weights = lumped<K - 1>(c, x, below);
  const Eigen::VectorXd known = inside<K - 1>(c, false);
  const Matrix delta = Eigen::VectorXd(known.cwiseQuotient(weights)).asDiagonal() *
                       Matrix(Matrix(d.transpose()) * mass);
  const Eigen::VectorXd own = lumped<K>(c, x, mass).cwiseProduct(inside<K>(c, true));
  return squared(Matrix(d * delta), own);
}

/// |delta d v|^2, of a (K+1)-form d v.
template <int K>
Matrix upAndDown(const Complex& c, const Array<Vec3>& x, const Matrix& mass) {
  const Matrix above = massMatrix<K + 1>(c, x);
  const Matrix d = coboundaryMatrix<K>(c);
  const Eigen::VectorXd weights = lumped<K>(c, x, mass);
  const Eigen::VectorXd known = inside<K>(c, false);
  const Matrix delta = Eigen::VectorXd(known.cwiseQuotient(weights)).asDiagonal() *
                       Matrix(Matrix(d.transpose()) * Matrix(above * d));
  return squared(delta, weights);
}

/// A cell's simplices of dimension K.
template <int K>
std::vector<Index> simplicesOf(const Complex& c, Index cell) {
  std::vector<Index> result;
  if constexpr (K == 1) {
    const int count = c.isTet(cell) ? 6 : 12;
    for (int k = 0; k < count; ++k) {
      result.push_back(
          (c.isTet(cell) ? c.tetEdge(cell, k) : c.octEdge(cell - c.tetCount(), k)).index());
    }
  } else {
    for (int k = 0; k < c.cellFacetCount(cell); ++k) result.push_back(c.cellFacet(cell, k).index());
  }
  return result;
}

Vec3 centroid(const Complex& c, const Array<Vec3>& x, Index cell) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < c.cellVertexCount(cell); ++k) sum += x[c.cellVertex(cell, k)];
  return sum / c.cellVertexCount(cell);
}

/// |grad v|^2: across each inner facet, how far the coefficients of either cell are from those of
/// the constant field that fits the other cell best.
template <int K>
Matrix gradientEnergy(const Complex& c, const Array<Vec3>& x) {
  const Eigen::MatrixX3d measure = measures<K>(c, x);
  const Eigen::MatrixX3d areas = measures<2>(c, x);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> weights;
  const auto addRows = [&](Index from, Index to, double weight) {
    const std::vector<Index> known = simplicesOf<K>(c, from), guessed = simplicesOf<K>(c, to);
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const Index s : known) moments += measure.row(s).transpose() * measure.row(s);
    const Eigen::Matrix3d inverse = moments.inverse();
    for (const Index g : guessed) {
      const int row = static_cast<int>(weights.size());
      const double size = measure.row(g).norm();
      entries.emplace_back(row, g, 1 / size);
      for (const Index s : known) {
        entries.emplace_back(row, s,
                             -measure.row(g).dot(inverse * measure.row(s).transpose()) / size);
      }
      // Mean over directions of a component's square: a third of the vector's.
      weights.push_back(3 * weight / static_cast<double>(guessed.size()));
    }
  };
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) continue;
    const Index a = c.facetCells[f][0].cell(), b = c.facetCells[f][1].cell();
    const double weight = areas.row(f).norm() / (centroid(c, x, a) - centroid(c, x, b)).norm() / 2;
    addRows(a, b, weight);
    addRows(b, a, weight);
  }
  Matrix rows(static_cast<Eigen::Index>(weights.size()), c.count(K));
  rows.setFromTriplets(entries.begin(), entries.end());
  return squared(rows, Eigen::Map<const Eigen::VectorXd>(weights.data(), rows.rows()));
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
  Matrix second(mass.rows(), mass.cols());
  // For a 2-form delta is the curl and d the divergence, for a 1-form the other way about.
  if (K == 2 ? curl : divergence) second += downAndUp<K>(c, x, mass);
  if (K == 2 ? divergence : curl) second += upAndDown<K>(c, x, mass);
  const double l2 = length * length;
  return (l2 * l2 * second + kFirstOrder * l2 * gradientEnergy<K>(c, x) + kZerothOrder * mass) /
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
