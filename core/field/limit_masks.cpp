// SPDX-License-Identifier: Apache-2.0
#include "limit_masks.h"

#include <Eigen/Dense>
#include <map>

#include "../refine/refiner.h"

namespace octet {
namespace {

Int3 difference(const Int3& a, const Int3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// The 1-ring of a regular vertex (the thesis' M_E, Fig. 2.4) as a control mesh, with its lattice.
class OneRing {
 public:
  explicit OneRing(double zeta) : patch_(0), refiner_(makeMesh(patch_), options(zeta)) {}

  /// Subdivision matrix of the 1-ring.
  template <int K>
  Eigen::MatrixXd matrix() const {
    const Complex& coarse = refiner_.complex(0);
    const Complex& fine = refiner_.complex(1);
    const Eigen::Index n = coarse.count(K);
    // The same simplices of the ring half the size, which the split makes around the centre.
    std::map<std::vector<Int3>, Index> atPoints;
    std::vector<Int3> finePoints(fine.vertexCount());
    for (Index v = 0; v < fine.vertexCount(); ++v) finePoints[v] = finePoint(v);
    for (Index s = 0; s < fine.count(K); ++s) atPoints[sortedPoints<K>(fine, finePoints, s)] = s;

    Eigen::MatrixXd result(n, n);
    for (Eigen::Index column = 0; column < n; ++column) {
      Cochain<K> unit(coarse);
      unit[static_cast<Index>(column)] = 1;
      const Cochain<K> refined = refiner_.step(0, unit, BoundaryMode::Walls);
      for (Eigen::Index row = 0; row < n; ++row) {
        const Index s = static_cast<Index>(row);
        const Index child = atPoints.at(sortedPoints<K>(coarse, patch_.points, s));
        result(row, column) = refined[child] * orientation<K>(fine, finePoints, child) *
                              orientation<K>(coarse, patch_.points, s);
      }
    }
    return result;
  }

  /// Coefficients of the constants: their columns.
  template <int K>
  Eigen::MatrixXd constants() const {
    const Complex& c = refiner_.complex(0);
    const auto at = [&](Index v) {
      const Int3& p = patch_.points[v];
      return Vec3(p[0], p[1], p[2]);
    };
    Eigen::MatrixXd result(c.count(K), K == 1 || K == 2 ? 3 : 1);
    for (Index s = 0; s < c.count(K); ++s) {
      if constexpr (K == 0) {
        result(s, 0) = 1;
      } else if constexpr (K == 1) {
        result.row(s) = at(c.edges[s][1]) - at(c.edges[s][0]);
      } else if constexpr (K == 2) {
        const auto v = c.facetVertices(s);
        result.row(s) = (at(v[1]) - at(v[0])).cross(at(v[2]) - at(v[0])) / 2;
      } else {
        result(s, 0) = c.isTet(s) ? 1.0 / 3 : 4.0 / 3;  // volumes in the lattice
      }
    }
    return result;
  }

  /// The simplex as base and class seen from the centre, and its sign along the class.
  template <int K>
  MaskTerm term(Index s, double* sign) const {
    const Complex& c = refiner_.complex(0);
    const Lattice& lattice = Lattice::get();
    const std::vector<Int3> points = sortedPoints<K>(c, patch_.points, s);
    MaskTerm term{0, {kSelf, kSelf, kSelf}, Vec3::Zero()};
    for (std::size_t i = 0; i < std::min<std::size_t>(points.size(), 3); ++i) {
      const auto found = std::find(lattice.neighbours.begin(), lattice.neighbours.end(), points[i]);
      term.vertices[i] = static_cast<std::uint8_t>(found - lattice.neighbours.begin());
    }
    *sign = orientation<K>(c, patch_.points, s);
    if constexpr (K == 1) {
      const Int3 step = difference(points[1], points[0]);
      term.simplexClass = static_cast<std::uint8_t>(
          std::find(lattice.edges.begin(), lattice.edges.end(), step) - lattice.edges.begin());
    } else if constexpr (K == 2) {
      const std::array<Int3, 2> steps = {difference(points[1], points[0]),
                                         difference(points[2], points[0])};
      term.simplexClass = static_cast<std::uint8_t>(
          std::find(lattice.facets.begin(), lattice.facets.end(), steps) - lattice.facets.begin());
    } else if constexpr (K == 3) {
      const Int3 step = difference(points[1], points[0]);
      term.simplexClass = points.size() == 6 ? 2 : step[2] > 0 ? 1 : 0;
    }
    return term;
  }

  Index count(int k) const { return refiner_.complex(0).count(k); }

 private:
  static RefinerOptions options(double zeta) {
    RefinerOptions result;
    result.levels = 1;
    result.zeta = zeta;
    return result;
  }

  static ControlMesh makeMesh(const LatticePatch& patch) {
    ControlMeshInput input;
    for (const Int3& p : patch.points) input.vertices.emplace_back(p[0], p[1], p[2]);
    input.tets.assign(patch.tets.begin(), patch.tets.end());
    input.octs.assign(patch.octs.begin(), patch.octs.end());
    return ControlMesh::build(std::move(input));
  }

  /// Where a fine vertex lies in the lattice of half the spacing, in its own coordinates.
  Int3 finePoint(Index v) const {
    const Complex& c = refiner_.complex(0);
    Index a = v, b = v;
    const ChildOf child = c.children().vertex(v);
    if (child.origin == Origin::Octahedron) {
      a = c.octs[child.parent][0];
      b = c.octs[child.parent][5];
    } else if (child.origin == Origin::Edge) {
      a = c.edges[child.parent][0];
      b = c.edges[child.parent][1];
    }
    const Int3 &p = patch_.points[a], &q = patch_.points[b];
    return {p[0] + q[0], p[1] + q[1], p[2] + q[2]};
  }

  template <int K>
  static std::vector<Index> storedVertices(const Complex& c, Index s) {
    if constexpr (K == 0) return {s};
    if constexpr (K == 1) return {c.edges[s][0], c.edges[s][1]};
    if constexpr (K == 2) {
      const auto v = c.facetVertices(s);
      return {v[0], v[1], v[2]};
    }
    std::vector<Index> v;
    for (int i = 0; i < c.cellVertexCount(s); ++i) v.push_back(c.cellVertex(s, i));
    return v;
  }
  template <int K>
  static std::vector<Int3> sortedPoints(const Complex& c, const std::vector<Int3>& points,
                                        Index s) {
    std::vector<Int3> result;
    for (const Index v : storedVertices<K>(c, s)) result.push_back(points[v]);
    std::sort(result.begin(), result.end());
    return result;
  }
  /// +1 when the stored order is an even permutation of the lexicographic one; cells have none.
  template <int K>
  static double orientation(const Complex& c, const std::vector<Int3>& points, Index s) {
    double sign = 1;
    if constexpr (K == 1 || K == 2) {
      const auto v = storedVertices<K>(c, s);
      for (std::size_t i = 0; i < v.size(); ++i) {
        for (std::size_t j = i + 1; j < v.size(); ++j) {
          if (points[v[j]] < points[v[i]]) sign = -sign;
        }
      }
    }
    return sign;
  }

  LatticePatch patch_;
  Refiner refiner_;
};

/// Left eigenvectors of `matrix` to `eigenvalue`, dual to the columns of `constants`; empty when
/// some other eigenvalue is as large.
Eigen::MatrixXd dualEigenvectors(const Eigen::MatrixXd& matrix, double eigenvalue,
                                 const Eigen::MatrixXd& constants) {
  const auto eigenvalues = matrix.eigenvalues();
  Eigen::Index dominant = 0;
  for (Eigen::Index k = 0; k < eigenvalues.size(); ++k) {
    if (std::abs(eigenvalues[k]) > eigenvalue * (1 - 1e-6)) ++dominant;
  }
  if (dominant != constants.cols()) return {};
  const Eigen::MatrixXd shifted =
      matrix.transpose() - eigenvalue * Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(shifted, Eigen::ComputeFullV);
  const Eigen::MatrixXd kernel = svd.matrixV().rightCols(constants.cols());
  return (kernel.transpose() * constants).inverse() * kernel.transpose();
}

template <int K>
void derive(const OneRing& ring, LimitMasks* masks) {
  constexpr double kEigenvalue[] = {1, 1.0 / 2, 1.0 / 4, 1.0 / 8};
  const Eigen::MatrixXd dual =
      dualEigenvectors(ring.matrix<K>(), kEigenvalue[K], ring.constants<K>());
  masks->exists[K] = dual.rows() > 0;
  if (!masks->exists[K]) return;
  for (Index s = 0; s < ring.count(K); ++s) {
    double sign;
    MaskTerm term = ring.term<K>(s, &sign);
    for (Eigen::Index row = 0; row < dual.rows(); ++row) term.weight[row] = sign * dual(row, s);
    if (term.weight.cwiseAbs().maxCoeff() > 1e-14) masks->terms[K].push_back(term);
  }
}

}  // namespace

LimitMasks::LimitMasks(double zeta) {
  const OneRing ring(zeta);
  derive<0>(ring, this);
  derive<1>(ring, this);
  derive<2>(ring, this);
  derive<3>(ring, this);
}

}  // namespace octet
