// SPDX-License-Identifier: Apache-2.0
#include "limit.h"

#include <Eigen/Dense>
#include <algorithm>

#include "../base/parallel.h"
#include "../rules/smoothing_rules.h"

namespace octet {
namespace {

/// At an irregular interior vertex the limit is taken as value + 2/3 (mean over the star - value):
/// the factor with which the regular limit mask and the regular mean have the same second moment.
constexpr double kMeanToLimit = 2.0 / 3;

/// Limit masks of the cubic B-spline, on a crease.
constexpr double kCreaseLimitSelf = 2.0 / 3, kCreaseLimitNeighbour = 1.0 / 6;

/// Directions in which a wall's normals spread less than this (as a squared sine) are along it.
constexpr double kFlatWall = 0.05;

/// Weight of a small gradient in a least-squares fit, relative to the data: one-sided stars do not
/// determine all of it, and what they leave open must not be extrapolated.
constexpr double kSmallGradient = 1e-3;

/// Coefficients of neighbouring simplices as equations for a linear field v + G (x - x0).
class LinearFit {
 public:
  explicit LinearFit(double scale) : scale_(scale) {}

  /// measure . (v + G offset) = value; `measure` is an edge or area vector.
  void add(const Vec3& measure, const Vec3& offset, double value) {
    const double w = 1 / measure.squaredNorm();
    Eigen::Matrix<double, 12, 1> row;
    row.head<3>() = measure;
    for (int k = 0; k < 3; ++k) row.segment<3>(3 + 3 * k) = measure * (offset[k] / scale_);
    normal_.selfadjointView<Eigen::Lower>().rankUpdate(row, w);
    right_ += (w * value) * row;
  }

  Vec3 solve() {
    const double mean = normal_.diagonal().head<3>().sum() / 3;
    if (!(mean > 0)) return Vec3::Zero();
    for (int k = 3; k < 12; ++k) normal_(k, k) += kSmallGradient * mean;
    const Eigen::LDLT<Eigen::Matrix<double, 12, 12>> factors(
        normal_.selfadjointView<Eigen::Lower>());
    return factors.solve(right_).head<3>();
  }

 private:
  double scale_;
  Eigen::Matrix<double, 12, 12> normal_ = Eigen::Matrix<double, 12, 12>::Zero();
  Eigen::Matrix<double, 12, 1> right_ = Eigen::Matrix<double, 12, 1>::Zero();
};

void sortUnique(std::vector<Index>* list) {
  std::sort(list->begin(), list->end());
  list->erase(std::unique(list->begin(), list->end()), list->end());
}

}  // namespace

Limit::Limit(const Refiner& refiner)
    : refiner_(refiner),
      c_(refiner.finest()),
      sites_(refiner.sites(refiner.levels())),
      coefficientPositions_(refiner.positions(refiner.levels())),
      masks_(refiner.zeta()) {
  positions_.resize(c_.vertexCount());
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    for (int axis = 0; axis < 3; ++axis) {
      positions_[v][axis] = valueAt(v, [&](Index u) { return coefficientPositions_[u][axis]; });
    }
  });
  prepareWalls();
}

/// Limit of a 0-form, `at(vertex)` giving its values.
template <typename At>
double Limit::valueAt(Index v, const At& at) const {
  if (!refiner_.smooth()) return at(v);
  const Index site = sites_.siteOfRegular(c_, v);
  if (site != kNone) {
    double sum = 0;
    for (const MaskTerm& term : masks_.terms[0]) {
      sum += term.weight[0] * at(sites_.vertices[sites_.hop(site, term.vertices[0])]);
    }
    return sum;
  }
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  const Index row = boundary.row(v);
  const double own = at(v);
  const auto other = [&](EdgeRef e) { return at(c_.edges[e.index()][e.reversed() ? 0 : 1]); };
  if (row != kNone) {
    if (boundary.kinds[row] == BoundaryKind::Corner) return own;
    double sum = 0;
    for (auto step = boundary.ringBegin(row); step != boundary.ringEnd(row); ++step) {
      const bool crease = c_.edgeFlags[step->edge.index()] & kOnCrease;
      if (!step->firstOfEdge || (boundary.kinds[row] == BoundaryKind::Crease && !crease)) continue;
      sum += other(step->edge);
    }
    if (boundary.kinds[row] == BoundaryKind::Crease) {
      return kCreaseLimitSelf * own + kCreaseLimitNeighbour * sum;
    }
    const int n = boundary.valence(row);
    const double weight = 1 / (3 / (8 * loopBeta(n)) + n);
    return (1 - n * weight) * own + weight * sum;
  }
  double mean = 0;
  int n = 0;
  c_.visitVertexStar(v, [&](const CellAtVertex& star) {
    ++n;
    if (c_.isTet(star.cell)) {
      for (int j = 0; j < 4; ++j) {
        if (j != star.place) mean += kTetVertexWeight * (at(c_.cellVertex(star.cell, j)) - own);
      }
      return;
    }
    const int opposite = Octahedron::opposite[star.place];
    const double across = at(c_.cellVertex(star.cell, opposite));
    for (int j = 0; j < 6; ++j) {
      if (j == star.place || j == opposite) continue;
      const double ring = at(c_.cellVertex(star.cell, j));
      mean += kOctVertexWeight * (ring - own) + kOctRingWeight * (across - ring);
    }
  });
  return n > 0 ? own + kMeanToLimit * mean / n : own;
}

Array<double> Limit::values(const Cochain<0>& form) const {
  Array<double> result(c_.vertexCount());
  parallelFor<Index>(c_.vertexCount(),
                     [&](Index v) { result[v] = valueAt(v, [&](Index u) { return form[u]; }); });
  return result;
}

Array<Vec3> Limit::vectors(const Cochain<1>& form, BoundaryMode mode) const {
  return vectorsOf<1>(form, mode);
}

Array<Vec3> Limit::vectors(const Cochain<2>& form, BoundaryMode mode) const {
  return vectorsOf<2>(form, mode);
}

template <int K>
Array<Vec3> Limit::vectorsOf(const Cochain<K>& form, BoundaryMode mode) const {
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  Array<Vec3> result(c_.vertexCount());
  parallelFor<Index>(
      c_.vertexCount(),
      [&](Index v) {
        const Index site =
            refiner_.smooth() && masks_.exists[K] ? sites_.siteOfRegular(c_, v) : kNone;
        if (site != kNone) {
          result[v] = regularVector<K>(site, form.data());
          return;
        }
        result[v] = fittedVector<K>(v, form.data());
        const Index row = boundary.row(v);
        if (row == kNone || mode == BoundaryMode::Open) return;
        // A wall: nothing crosses it (2-forms), or nothing runs along it (1-forms).
        const bool closed =
            std::all_of(boundary.ringBegin(row), boundary.ringEnd(row), [&](const RingStep& step) {
              return (K == 2 ? form[step.facet] : form[step.edge.index()]) == 0;
            });
        if (!closed) return;
        const Vec3 along = walls_[row] * result[v];
        result[v] = K == 2 ? along : Vec3(result[v] - along);
      },
      256);
  return result;
}

/// In lattice coordinates, then to space: through the Jacobian of the positions for a 1-form, and
/// through the area vectors, which are what a constant field's coefficients are made of, for a
/// 2-form. Both make constants exact.
template <int K>
Vec3 Limit::regularVector(Index site, const double* form) const {
  Index sites[kNeighbours + 1];
  Vec3 points[kNeighbours + 1];
  for (int k = 0; k <= kNeighbours; ++k) {
    sites[k] = sites_.hop(site, static_cast<std::uint8_t>(k));
    points[k] = coefficientPositions_[sites_.vertices[sites[k]]];
  }
  Vec3 inLattice = Vec3::Zero();
  Eigen::Matrix3d ofConstants = Eigen::Matrix3d::Zero();  // column k: the mask on constant k
  for (const MaskTerm& term : masks_.terms[K]) {
    const auto& [a, b, c] = term.vertices;
    LatticeRef ref;
    Vec3 measure;
    if constexpr (K == 1) {
      ref = sites_.edges[sites[a]][term.simplexClass];
      measure = points[b] - points[a];
    } else {
      ref = sites_.facets[sites[a]][term.simplexClass];
      measure = (points[b] - points[a]).cross(points[c] - points[a]) / 2;
    }
    inLattice += (ref.sign() * form[ref.index()]) * term.weight;
    ofConstants += term.weight * measure.transpose();
  }
  return ofConstants.inverse() * inLattice;
}

template <int K>
Vec3 Limit::fittedVector(Index v, const double* form) const {
  std::vector<Index> cells, simplices;
  c_.visitVertexStar(v, [&](const CellAtVertex& at) { cells.push_back(at.cell); });
  // A star of few cells does not determine a gradient: take the cells beside it too.
  constexpr std::size_t kFewCells = 8;
  if (cells.size() < kFewCells) {
    const std::size_t n = cells.size();
    for (std::size_t k = 0; k < n; ++k) {
      for (int f = 0; f < c_.cellFacetCount(cells[k]); ++f) {
        for (const CellSide& side : c_.facetCells[c_.cellFacet(cells[k], f).index()]) {
          if (side.exists()) cells.push_back(side.cell());
        }
      }
    }
    sortUnique(&cells);
  }
  for (const Index cell : cells) {
    for (int f = 0; f < c_.cellFacetCount(cell); ++f) {
      const Index facet = c_.cellFacet(cell, f).index();
      if (K == 2) {
        simplices.push_back(facet);
      } else {
        for (const EdgeRef& e : c_.facetEdges[facet]) simplices.push_back(e.index());
      }
    }
  }
  sortUnique(&simplices);
  if (simplices.empty()) return Vec3::Zero();
  const Vec3& centre = positions_[v];
  double scale = 0;
  for (const Index cell : cells) {
    scale = std::max(scale, (coefficientPositions_[c_.cellVertex(cell, 0)] - centre).norm());
    scale = std::max(scale, (coefficientPositions_[c_.cellVertex(cell, 1)] - centre).norm());
  }
  LinearFit fit(scale);
  for (const Index s : simplices) {
    if constexpr (K == 1) {
      const Vec3& a = coefficientPositions_[c_.edges[s][0]];
      const Vec3& b = coefficientPositions_[c_.edges[s][1]];
      fit.add(b - a, (a + b) / 2 - centre, form[s]);
    } else {
      const auto vs = c_.facetVertices(s);
      const Vec3 &p = coefficientPositions_[vs[0]], &q = coefficientPositions_[vs[1]],
                 &r = coefficientPositions_[vs[2]];
      fit.add((q - p).cross(r - p) / 2, (p + q + r) / 3 - centre, form[s]);
    }
  }
  return fit.solve();
}

void Limit::prepareWalls() {
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  walls_.resize(boundary.vertices.size());
  parallelFor<Index>(boundary.vertexCount(),
                     [&](Index row) { walls_[row] = tangentialProjection(row); });
}

/// Onto the directions along the wall: off its limit normal where it is smooth; on creases and
/// corners, off all directions in which the normals of its facets spread.
Eigen::Matrix3d Limit::tangentialProjection(Index row) const {
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  const auto* const begin = boundary.ringBegin(row);
  const Index n = static_cast<Index>(boundary.ringEnd(row) - begin);
  const auto point = [&](const RingStep& step) {
    return coefficientPositions_[c_.edges[step.edge.index()][step.edge.reversed() ? 0 : 1]];
  };
  if (boundary.kinds[row] == BoundaryKind::Smooth && boundary.valence(row) == n &&
      refiner_.smooth()) {
    // Tangents of Loop's limit surface.
    Vec3 first = Vec3::Zero(), second = Vec3::Zero();
    for (Index k = 0; k < n; ++k) {
      const double turn = 2 * 3.14159265358979323846 * k / n;
      first += std::cos(turn) * point(begin[k]);
      second += std::sin(turn) * point(begin[k]);
    }
    const Vec3 normal = first.cross(second).normalized();
    if (normal.allFinite() && normal.squaredNorm() > 0.5) {
      return Eigen::Matrix3d::Identity() - normal * normal.transpose();
    }
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Index k = 0; k < n; ++k) {
    const auto v = c_.facetVertices(begin[k].facet);
    const Vec3 area = (coefficientPositions_[v[1]] - coefficientPositions_[v[0]])
                          .cross(coefficientPositions_[v[2]] - coefficientPositions_[v[0]]);
    if (area.norm() > 0) spread += area * area.transpose() / area.norm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  Eigen::Matrix3d projection = Eigen::Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) {
    if (eigen.eigenvalues()[k] > kFlatWall * eigen.eigenvalues()[2]) {
      const Vec3 normal = eigen.eigenvectors().col(k);
      projection -= normal * normal.transpose();
    }
  }
  return projection;
}

Array<double> Limit::densities(const Cochain<3>& form) const {
  Array<double> volumes(c_.cellCount());
  parallelFor<Index>(c_.cellCount(), [&](Index cell) {
    volumes[cell] = c_.cellSigns[cell] * cellVolume6(c_, coefficientPositions_, cell) / 6;
  });
  Array<double> result(c_.vertexCount());
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    double mass = 0, volume = 0;
    const Index site = refiner_.smooth() && masks_.exists[3] ? sites_.siteOfRegular(c_, v) : kNone;
    if (site != kNone) {
      for (const MaskTerm& term : masks_.terms[3]) {
        const LatticeRef ref = sites_.cells[sites_.hop(site, term.vertices[0])][term.simplexClass];
        mass += term.weight[0] * form[ref.index()];
        volume += term.weight[0] * volumes[ref.index()];
      }
    } else {
      c_.visitVertexStar(v, [&](const CellAtVertex& at) {
        mass += form[at.cell];
        volume += volumes[at.cell];
      });
    }
    result[v] = volume != 0 ? mass / volume : 0.0;
  });
  return result;
}

}  // namespace octet
