// SPDX-License-Identifier: Apache-2.0
#include "continuity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "../forms/coboundary.h"
#include "dense_algebra.h"
#include "spectrum.h"

namespace octet {
namespace {

/// Parts of an eigenform smaller than this, relative to the whole, are rounding.
constexpr double kNoPart = 1e-6;

/// d of all (K-1)-forms of the star: as it is a ball, all closed K-forms.
template <int K>
Eigen::MatrixXd closedForms(const Complex& star) {
  Eigen::MatrixXd result(star.count(K), star.count(K - 1));
  for (Index s = 0; s < star.count(K - 1); ++s) {
    Cochain<K - 1> unit(star);
    unit[s] = 1;
    const auto image = d(star, unit);
    for (Index k = 0; k < image.size(); ++k) result(k, s) = image[k];
  }
  return orthonormalSpan(result);
}

/// The directions that a step stretches without turning, as columns, and by how much; where it
/// turns a plane, any basis of that plane.
struct Frame {
  Eigen::Matrix3d directions;
  Eigen::Vector3d factors;
};

Frame principalFrame(const LocalSubdivision& local) {
  const Eigen::MatrixXd gradients = local.constants<1>();
  const Eigen::Matrix3d step = leastSquares(gradients, local.matrix<1>() * gradients);
  const Eigen::EigenSolver<Eigen::Matrix3d> solver(step);
  Frame frame;
  for (int k = 0; k < 3; ++k) {
    const std::complex<double> value = solver.eigenvalues()[k];
    const Eigen::Vector3cd vector = solver.eigenvectors().col(k);
    frame.factors[k] = std::abs(value);
    frame.directions.col(k) = vector.real();
    if (value.imag() < 0) frame.directions.col(k) = vector.imag();
  }
  return frame;
}

/// Mean square of the vectors of a form at cell corners, by component; positions in the frame.
template <int K>
Eigen::Vector3d parts(const Complex& star, const Array<Vec3>& positions,
                      const Eigen::VectorXcd& form) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Index cell = 0; cell < star.cellCount(); ++cell) {
    if (star.tetCount() > 0 && !star.isTet(cell)) break;
    for (int i = 0; i < star.cellVertexCount(cell); ++i) {
      std::vector<std::pair<Vec3, std::complex<double>>> rows;
      if constexpr (K == 1) {
        for (int j = 0; j < star.cellVertexCount(cell); ++j) {
          if (i == j || (!star.isTet(cell) && Octahedron::opposite[i] == j)) continue;
          const EdgeRef e = star.cellEdge(cell, i, j);
          rows.emplace_back(
              positions[star.cellVertex(cell, j)] - positions[star.cellVertex(cell, i)],
              e.sign() * form[e.index()]);
        }
      } else {
        for (int k = 0; k < star.cellFacetCount(cell); ++k) {
          const Index facet = star.cellFacet(cell, k).index();
          const auto v = star.facetVertices(facet);
          if (std::find(v.begin(), v.end(), star.cellVertex(cell, i)) == v.end()) continue;
          rows.emplace_back(
              (positions[v[1]] - positions[v[0]]).cross(positions[v[2]] - positions[v[0]]) / 2,
              form[facet]);
        }
      }
      Eigen::MatrixXcd left(rows.size(), 3);
      Eigen::VectorXcd right(rows.size());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        left.row(static_cast<Eigen::Index>(k)) =
            rows[k].first.transpose().cast<std::complex<double>>();
        right[static_cast<Eigen::Index>(k)] = rows[k].second;
      }
      sum += pivotedLeastSquares(left, right).cwiseAbs2();
    }
  }
  return sum;
}

}  // namespace

template <int K>
Continuity continuity(const LocalSubdivision& local, bool closedOnly) {
  const Complex& star = local.star();
  const Frame frame = principalFrame(local);
  Array<Vec3> positions(star.vertexCount());
  for (Index v = 0; v < star.vertexCount(); ++v) {
    positions[v] = frame.directions.transpose() * local.positions()[v];
  }
  const Eigen::MatrixXd matrix = local.matrix<K>(), constants = local.constants<K>();
  Continuity result;
  result.constantsError = invarianceDefect(matrix, constants);
  const Eigen::Vector3d& f = frame.factors;
  result.constants = K == 1 ? f : Eigen::Vector3d(f[1] * f[2], f[2] * f[0], f[0] * f[1]);

  const Eigen::MatrixXd within =
      closedOnly ? closedForms<K>(star) : Eigen::MatrixXd::Identity(star.count(K), star.count(K));
  const EigenDecomposition eigen = eigenDecomposition(within.transpose() * matrix * within);
  const Eigen::MatrixXcd known = constants.cast<std::complex<double>>();
  for (Eigen::Index k = 0; k < eigen.values.size(); ++k) {
    const double size = std::abs(eigen.values[k]);
    if (size <= result.growth * result.constants.minCoeff()) continue;  // cannot be the worst
    Eigen::VectorXcd form = within * eigen.vectors.col(k);
    const Eigen::VectorXcd rest = form - known * leastSquares(known, form);
    if (rest.norm() < kNoPart * form.norm()) continue;  // a constant field
    // Where a constant has the same eigenvalue it may be mixed in.
    if ((result.constants.array() - size).abs().minCoeff() < kSameEigenvalue) form = rest;
    const Eigen::Vector3d vectors = parts<K>(star, positions, form).cwiseSqrt();
    for (int i = 0; i < 3; ++i) {
      if (vectors[i] < kNoPart * vectors.norm()) continue;
      const double growth = size / result.constants[i];
      if (growth <= result.growth) continue;
      result.growth = growth;
      result.eigenvalue = size;
    }
  }
  return result;
}

template Continuity continuity<1>(const LocalSubdivision&, bool);
template Continuity continuity<2>(const LocalSubdivision&, bool);

}  // namespace octet
