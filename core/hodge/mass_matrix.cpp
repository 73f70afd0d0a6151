// SPDX-License-Identifier: Apache-2.0
#include "mass_matrix.h"

#include <Eigen/Dense>

#include "../base/parallel.h"
#include "../field/whitney_piece.h"

namespace octet {
namespace {

template <int K, typename Shape>
using Vector = Eigen::Matrix<double, kLocalCount<K, Shape>, 1>;
template <int K, typename Shape>
using Square = Eigen::Matrix<double, kLocalCount<K, Shape>, kLocalCount<K, Shape>>;

/// The fields of all basis forms of a tetrahedron, by component and corner.
template <int K>
struct CornerValues {
  explicit CornerValues(const std::array<Vec3, 4>& p) {
    volume = std::abs(volume6<Tetrahedron>(p)) / 6;
    for (int k = 0; k < kLocalCount<K, Tetrahedron>; ++k) {
      LocalForm<K, Tetrahedron> basis{};
      basis[k] = 1;
      const auto piece = whitneyPiece<K>(p, p, basis);
      for (int corner = 0; corner < 4; ++corner) {
        for (int c = 0; c < kComponents<K>; ++c) at[c](k, corner) = piece.values[corner][c];
      }
    }
  }

  /// Integrals of component a of each basis field times component b of each: linear functions f and
  /// g have volume / 20 (sum f_i g_i + sum f_i sum g_i).
  Square<K, Tetrahedron> integrals(int a, int b) const {
    return volume / 20 *
           (at[a] * at[b].transpose() + at[a].rowwise().sum() * at[b].rowwise().sum().transpose());
  }

  double volume;
  std::array<Eigen::Matrix<double, kLocalCount<K, Tetrahedron>, 4>, kComponents<K>> at;
};

template <int K>
Square<K, Tetrahedron> tetrahedronMass(const std::array<Vec3, 4>& p) {
  const CornerValues<K> basis(p);
  Square<K, Tetrahedron> mass = basis.integrals(0, 0);
  for (int c = 1; c < kComponents<K>; ++c) mass += basis.integrals(c, c);
  return mass;
}

/// Vertices of the regular octahedron with axes x, y, z: opposite pairs (0,5) (1,3) (2,4).
std::array<Vec3, 6> regularOctahedron() {
  return {Vec3::UnitX(),  Vec3::UnitY(),  Vec3::UnitZ(),
          -Vec3::UnitY(), -Vec3::UnitZ(), -Vec3::UnitX()};
}

/// Integrals over the regular octahedron of component a times component b of its basis forms.
template <int K>
class RegularIntegrals {
 public:
  static constexpr int C = kComponents<K>;
  using Matrix = Square<K, Octahedron>;

  static const RegularIntegrals& get() {
    static const RegularIntegrals integrals;
    return integrals;
  }
  const Matrix& at(int a, int b) const { return integrals_[a * C + b]; }

 private:
  RegularIntegrals() : split_(LinearRules()) {
    std::array<Matrix, C * C> ofTets;
    for (Matrix& m : ofTets) m.setZero();
    addTetrahedra(&ofTets);
    for (int k = 0; k < 6; ++k) {
      children_[k] = matrixOf<Octahedron>([&](const auto& w) { return split_.oct(k, w); });
    }
    // Six child octahedra of half the size hold the rest: N = tetrahedra + s sum R' N R. Their
    // share of the volume, 3/4, is the rate at which the sum converges for constants, the slowest.
    const double scale = std::pow(0.5, 3 - 2 * K);
    integrals_ = ofTets;
    constexpr int kEnough = 160;  // (3/4)^160 = 1e-20
    for (int n = 0; n < kEnough; ++n) {
      for (int ab = 0; ab < C * C; ++ab) {
        Matrix next = ofTets[ab];
        for (const Matrix& r : children_) next += scale * r.transpose() * integrals_[ab] * r;
        integrals_[ab] = next;
      }
    }
  }

  template <typename Shape, typename Map>
  static Eigen::Matrix<double, kLocalCount<K, Shape>, kLocalCount<K, Octahedron>> matrixOf(
      const Map& map) {
    Eigen::Matrix<double, kLocalCount<K, Shape>, kLocalCount<K, Octahedron>> result;
    for (int j = 0; j < kLocalCount<K, Octahedron>; ++j) {
      LocalForm<K, Octahedron> basis{};
      basis[j] = 1;
      const auto image = map(basis);
      for (std::size_t i = 0; i < image.size(); ++i) result(static_cast<int>(i), j) = image[i];
    }
    return result;
  }

  /// The eight child tetrahedra around the centre.
  void addTetrahedra(std::array<Matrix, C * C>* sum) const {
    const std::array<Vec3, 6> x = regularOctahedron();
    for (int k = 0; k < 8; ++k) {
      std::array<Vec3, 4> p;
      for (int i = 0; i < 4; ++i) {
        const int label = SplitTables<Octahedron>::get().tets[k][i];
        p[i] =
            label == kCentreLabel
                ? Vec3::Zero()
                : Vec3((x[Octahedron::edges[label - 6][0]] + x[Octahedron::edges[label - 6][1]]) /
                       2);
      }
      const CornerValues<K> basis(p);
      const auto r = matrixOf<Tetrahedron>([&](const auto& w) { return split_.tet(k, w); });
      for (int a = 0; a < C; ++a) {
        for (int b = 0; b < C; ++b) {
          (*sum)[a * C + b] += r.transpose() * basis.integrals(a, b) * r;
        }
      }
    }
  }

  OctahedronSplit<K> split_;
  std::array<Matrix, 6> children_;
  std::array<Matrix, C * C> integrals_;
};

/// The coefficients that constant fields have: functions, edge vectors, outward area vectors.
template <int K>
Eigen::Matrix<double, kLocalCount<K, Octahedron>, kComponents<K>> ofConstants(
    const std::array<Vec3, 6>& p) {
  Eigen::Matrix<double, kLocalCount<K, Octahedron>, kComponents<K>> result;
  for (int k = 0; k < kLocalCount<K, Octahedron>; ++k) {
    if constexpr (K == 1) {
      result.row(k) = p[Octahedron::edges[k][1]] - p[Octahedron::edges[k][0]];
    } else if constexpr (K == 2) {
      const auto& t = Octahedron::facets[k];
      result.row(k) = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
    } else {
      result(k, 0) = 1;
    }
  }
  return result;
}

/// The mean of a form's field over an octahedron, as its facets see it, so that parts of constant
/// fields cancel between cells: of a 2-form, from the flux through each facet, with even
/// divergence; of a gradient, from the values on the facets. On an affine octahedron `nearest`, the
/// constant nearest to the form, is the same.
template <int K>
Eigen::Matrix<double, 3, kLocalCount<K, Octahedron>> meanOf(
    const std::array<Vec3, 6>& p,
    const Eigen::Matrix<double, 3, kLocalCount<K, Octahedron>>& nearest) {
  if constexpr (K == 2) {
    const Vec3 middle = (p[0] + p[1] + p[2] + p[3] + p[4] + p[5]) / 6;
    Vec3 centroid = Vec3::Zero();
    Eigen::Matrix<double, 3, 8> facets;
    for (int k = 0; k < 8; ++k) {
      const auto& t = Octahedron::facets[k];
      const Vec3 a = p[t[0]] - middle, b = p[t[1]] - middle, c = p[t[2]] - middle;
      facets.col(k) = (a + b + c) / 3;
      centroid += a.dot(b.cross(c)) * (a + b + c) / 24;
    }
    const double signedVolume = volume6<Octahedron>(p) / 6;
    return (facets.colwise() - centroid / signedVolume) / signedVolume;
  } else {
    Eigen::Matrix<double, 12, 6> d = Eigen::Matrix<double, 12, 6>::Zero();
    for (int k = 0; k < 12; ++k) {
      d(k, Octahedron::edges[k][0]) = -1;
      d(k, Octahedron::edges[k][1]) = 1;
    }
    Eigen::Matrix<double, 3, 6> ofGradients = Eigen::Matrix<double, 3, 6>::Zero();
    for (const auto& t : Octahedron::facets) {
      const Vec3 area = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
      for (int k = 0; k < 3; ++k) ofGradients.col(t[k]) += area / 3;
    }
    ofGradients /= volume6<Octahedron>(p) / 6;
    return nearest +
           (ofGradients - nearest * d) * d.completeOrthogonalDecomposition().pseudoInverse();
  }
}

template <int K>
Square<K, Octahedron> octahedronMass(const std::array<Vec3, 6>& p) {
  Eigen::Matrix3d jacobian;  // of the affine octahedron with the same axes, and the same volume
  jacobian << (p[0] - p[5]) / 2, (p[1] - p[3]) / 2, (p[2] - p[4]) / 2;
  const double det = std::abs(jacobian.determinant());
  const auto& regular = RegularIntegrals<K>::get();
  Square<K, Octahedron> mass;
  if constexpr (K == 0) return det * regular.at(0, 0);
  if constexpr (K == 3) return regular.at(0, 0) / det;
  if constexpr (K == 1 || K == 2) {
    // Vectors map by J^-T (1-forms) or J / det (2-forms).
    const Eigen::Matrix3d metric =
        K == 1 ? Eigen::Matrix3d(det * (jacobian.transpose() * jacobian).inverse())
               : Eigen::Matrix3d(jacobian.transpose() * jacobian / det);
    mass.setZero();
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) mass += metric(a, b) * regular.at(a, b);
    }
    // x = Q c + rest, where c is the mean of x.
    const auto q = ofConstants<K>(p);
    const Eigen::Matrix3d ofQ = q.transpose() * mass * q;
    const double volume = std::abs(volume6<Octahedron>(p)) / 6;
    const Eigen::Matrix<double, 3, kLocalCount<K, Octahedron>> toConstant =
        meanOf<K>(p, ofQ.ldlt().solve(q.transpose() * mass));
    const Square<K, Octahedron> rest = Square<K, Octahedron>::Identity() - q * toConstant;
    mass = (rest.transpose() * mass * rest + volume * toConstant.transpose() * toConstant).eval();
    mass = ((mass + mass.transpose()) / 2).eval();
  }
  return mass;
}

/// Where a local coefficient stands in the level's arrays.
struct Place {
  Index index;
  double sign;
};

template <int K, typename Shape>
std::array<Place, kLocalCount<K, Shape>> placesOf(const Complex& c, Index cell) {
  std::array<Place, kLocalCount<K, Shape>> places;
  for (int k = 0; k < kLocalCount<K, Shape>; ++k) {
    if constexpr (K == 0) places[k] = {c.cellVertex(cell, k), 1};
    if constexpr (K == 1) {
      const EdgeRef e = c.cellEdge(cell, Shape::edges[k][0], Shape::edges[k][1]);
      places[k] = {e.index(), e.sign()};
    }
    if constexpr (K == 2) {
      const FacetRef f = c.cellFacet(cell, k);
      places[k] = {f.index(), f.sign()};
    }
    if constexpr (K == 3) places[k] = {cell, 1};
  }
  return places;
}

template <int K, typename Shape, typename MassOf>
void addCells(const Complex& c, const Array<Vec3>& x, Index first, Index count,
              const MassOf& massOf, std::vector<Eigen::Triplet<double, Index>>* entries) {
  constexpr std::size_t n = kLocalCount<K, Shape>;
  const std::size_t begin = entries->size();
  entries->resize(begin + n * n * static_cast<std::size_t>(count));
  parallelFor<Index>(
      count,
      [&](Index k) {
        std::array<Vec3, Shape::kVertices> p;
        for (int i = 0; i < Shape::kVertices; ++i) p[i] = x[c.cellVertex(first + k, i)];
        const Square<K, Shape> mass = massOf(p);
        const auto places = placesOf<K, Shape>(c, first + k);
        auto* out = entries->data() + begin + n * n * static_cast<std::size_t>(k);
        for (std::size_t i = 0; i < n; ++i) {
          for (std::size_t j = 0; j < n; ++j) {
            *out++ = {
                places[i].index, places[j].index,
                places[i].sign * places[j].sign * mass(static_cast<int>(i), static_cast<int>(j))};
          }
        }
      },
      64);
}

}  // namespace

template <int K>
Eigen::SparseMatrix<double> massMatrix(const Complex& complex, const Array<Vec3>& positions) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  addCells<K, Tetrahedron>(complex, positions, 0, complex.tetCount(), tetrahedronMass<K>, &entries);
  addCells<K, Octahedron>(complex, positions, complex.tetCount(), complex.octCount(),
                          octahedronMass<K>, &entries);
  Eigen::SparseMatrix<double> result(complex.count(K), complex.count(K));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

template Eigen::SparseMatrix<double> massMatrix<0>(const Complex&, const Array<Vec3>&);
template Eigen::SparseMatrix<double> massMatrix<1>(const Complex&, const Array<Vec3>&);
template Eigen::SparseMatrix<double> massMatrix<2>(const Complex&, const Array<Vec3>&);
template Eigen::SparseMatrix<double> massMatrix<3>(const Complex&, const Array<Vec3>&);

}  // namespace octet
