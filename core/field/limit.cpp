// SPDX-License-Identifier: Apache-2.0
#include "limit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <optional>

#include "../base/numbers.h"
#include "../base/reported_loop.h"
#include "../base/sort_unique.h"
#include "../rules/smoothing_rules.h"

namespace octet {
namespace {

/// At an irregular interior vertex the limit is taken as value + 2/3 (mean over the star - value):
/// the factor with which the regular limit mask and the regular mean have the same second moment.
constexpr double kMeanToLimit = 2.0 / 3;

/// Limit masks of the cubic B-spline, on a crease.
constexpr double kCreaseLimitSelf = 2.0 / 3, kCreaseLimitNeighbour = 1.0 / 6;

/// The weight of each neighbour in the limit of a smooth wall vertex of valence n: the left
/// eigenvector of Loop's rule (SCHEME.md section 8) or, from the second split on, of section 8b's.
double wallWeight(const Refiner& refiner, int n) {
  const double loop = loopBeta(n);
  if (refiner.boundaryRows() != BoundaryRows::Smooth) return 1 / (3 / (8 * loop) + n);
  return refiner.levels() == 0 ? loop / 2 + 5.0 / (16 * n) : 1.0 / (2 * n);
}

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
    if (!keepGradientSmall()) return Vec3::Zero();
    const Eigen::LDLT<Eigen::Matrix<double, 12, 12>> factors(
        normal_.selfadjointView<Eigen::Lower>());
    return factors.solve(right_).head<3>();
  }

  /// How v depends on the right side: solve() is this, transposed, times the sum of the rows.
  Eigen::Matrix<double, 12, 3> influence() {
    if (!keepGradientSmall()) return Eigen::Matrix<double, 12, 3>::Zero();
    const Eigen::LDLT<Eigen::Matrix<double, 12, 12>> factors(
        normal_.selfadjointView<Eigen::Lower>());
    return factors.solve(Eigen::Matrix<double, 12, 3>::Identity());
  }

  /// The equation's weight times its row: by what a value of 1 adds to the right side.
  Eigen::Matrix<double, 12, 1> weightedRow(const Vec3& measure, const Vec3& offset) const {
    Eigen::Matrix<double, 12, 1> row;
    row.head<3>() = measure;
    for (int k = 0; k < 3; ++k) row.segment<3>(3 + 3 * k) = measure * (offset[k] / scale_);
    return row / measure.squaredNorm();
  }

 private:
  bool keepGradientSmall() {
    const double mean = normal_.diagonal().head<3>().sum() / 3;
    if (!(mean > 0)) return false;
    for (int k = 3; k < 12; ++k) normal_(k, k) += kSmallGradient * mean;
    return true;
  }

  double scale_;
  Eigen::Matrix<double, 12, 12> normal_ = Eigen::Matrix<double, 12, 12>::Zero();
  Eigen::Matrix<double, 12, 1> right_ = Eigen::Matrix<double, 12, 1>::Zero();
};

}  // namespace

Limit::Limit(const Refiner& refiner, const Context& context)
    : refiner_(refiner),
      c_(refiner.finest()),
      sites_(refiner.sites(refiner.levels())),
      coefficientPositions_(refiner.positions(refiner.levels())),
      masks_(refiner.zeta()),
      starLimits_(refiner.smooth() && refiner.zeta() == kDefaultZeta ? StarLimits(c_)
                                                                     : StarLimits()) {
  positions_.resize(c_.vertexCount());
  const auto limitOf = [&](Index v) {
    for (int axis = 0; axis < 3; ++axis) {
      positions_[v][axis] = valueAt(v, [&](Index u) { return coefficientPositions_[u][axis]; });
    }
  };
  reportedFor<Index>(c_.vertexCount(), limitOf, context, "limit of positions", "vertices");
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
    const double weight = wallWeight(refiner_, n);
    return (1 - n * weight) * own + weight * sum;
  }
  if (const auto limit = starLimits_.value(v, at)) return *limit;
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

Array<double> Limit::values(const Cochain<0>& form, const Context& context) const {
  form.checkOn(c_);
  Array<double> result(c_.vertexCount());
  const auto limitOf = [&](Index v) { result[v] = valueAt(v, [&](Index u) { return form[u]; }); };
  reportedFor<Index>(c_.vertexCount(), limitOf, context, "limit of values", "vertices");
  return result;
}

Array<Vec3> Limit::vectors(const Cochain<1>& form, BoundaryMode mode,
                           const Context& context) const {
  return vectorsOf<1>(form, mode, context);
}

Array<Vec3> Limit::vectors(const Cochain<2>& form, BoundaryMode mode,
                           const Context& context) const {
  return vectorsOf<2>(form, mode, context);
}

template <int K>
Array<Vec3> Limit::vectorsOf(const Cochain<K>& form, BoundaryMode mode,
                             const Context& context) const {
  form.checkOn(c_);
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  Array<Vec3> result(c_.vertexCount());
  reportedFor<Index>(
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
        if (!onClosedWall<K>(row, form.data())) return;
        const Vec3 along = walls_[row] * result[v];
        result[v] = K == 2 ? along : Vec3(result[v] - along);
      },
      context, "limit of vectors", "vertices", 256);
  return result;
}

template <int K>
bool Limit::onClosedWall(Index row, const double* form) const {
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  return std::all_of(boundary.ringBegin(row), boundary.ringEnd(row), [&](const RingStep& step) {
    return form[K == 2 ? step.facet : step.edge.index()] == 0;
  });
}

template <int K>
std::vector<std::uint8_t> Limit::closedWalls(const Cochain<K>& form, BoundaryMode mode) const {
  form.checkOn(c_);
  const Boundary& boundary = refiner_.boundary(refiner_.levels());
  std::vector<std::uint8_t> result(static_cast<std::size_t>(c_.vertexCount()), 0);
  if (mode == BoundaryMode::Open) return result;
  for (Index row = 0; row < boundary.vertexCount(); ++row) {
    result[boundary.vertices[row]] = onClosedWall<K>(row, form.data());
  }
  return result;
}

template <int K>
std::array<SparseRow, 3> Limit::vectorRows(Index v, bool onClosedWall) const {
  std::vector<std::pair<Index, Vec3>> terms;
  const Index site = refiner_.smooth() && masks_.exists[K] ? sites_.siteOfRegular(c_, v) : kNone;
  Eigen::Matrix3d outer = Eigen::Matrix3d::Identity();
  if (site != kNone) {
    const Eigen::Matrix3d ofConstants = addRegular<K>(site, [&](LatticeRef ref, const Vec3& w) {
      terms.emplace_back(ref.index(), ref.sign() * w);
    });
    outer = ofConstants.inverse();
  } else {
    std::optional<LinearFit> fit;
    const auto begin = [&](double scale) { fit.emplace(scale); };
    addStar<K>(v, begin, [&](Index, const Vec3& m, const Vec3& offset) { fit->add(m, offset, 0); });
    if (fit) {
      const Eigen::Matrix<double, 12, 3> influence = fit->influence();
      addStar<K>(
          v, [](double) {},
          [&](Index s, const Vec3& m, const Vec3& offset) {
            terms.emplace_back(s, influence.transpose() * fit->weightedRow(m, offset));
          });
    }
    const Index row = refiner_.boundary(refiner_.levels()).row(v);
    if (onClosedWall && row != kNone) {
      outer = K == 2 ? walls_[row] : Eigen::Matrix3d(outer - walls_[row]);
    }
  }
  std::sort(terms.begin(), terms.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::array<SparseRow, 3> rows;
  for (const auto& [index, weight] : terms) {
    const Vec3 w = outer * weight;
    for (int axis = 0; axis < 3; ++axis) {
      rows[axis].index.push_back(index);
      rows[axis].weight.push_back(w[axis]);
    }
  }
  return rows;
}

template std::array<SparseRow, 3> Limit::vectorRows<1>(Index, bool) const;
template std::array<SparseRow, 3> Limit::vectorRows<2>(Index, bool) const;
template std::vector<std::uint8_t> Limit::closedWalls(const Cochain<1>&, BoundaryMode) const;
template std::vector<std::uint8_t> Limit::closedWalls(const Cochain<2>&, BoundaryMode) const;

/// In lattice coordinates, then to space: through the Jacobian of the positions for a 1-form, and
/// through the area vectors, which are what a constant field's coefficients are made of, for a
/// 2-form. Both make constants exact.
template <int K>
Vec3 Limit::regularVector(Index site, const double* form) const {
  Vec3 inLattice = Vec3::Zero();
  const Eigen::Matrix3d ofConstants = addRegular<K>(site, [&](LatticeRef ref, const Vec3& w) {
    inLattice += (ref.sign() * form[ref.index()]) * w;
  });
  return ofConstants.inverse() * inLattice;
}

/// Calls `add(ref, weight)` for the terms of a mask. @return column k: the mask on constant k
template <int K, typename Add>
Eigen::Matrix3d Limit::addRegular(Index site, const Add& add) const {
  Index sites[kNeighbours + 1];
  Vec3 points[kNeighbours + 1];
  for (int k = 0; k <= kNeighbours; ++k) {
    sites[k] = sites_.hop(site, static_cast<std::uint8_t>(k));
    points[k] = coefficientPositions_[sites_.vertices[sites[k]]];
  }
  Eigen::Matrix3d ofConstants = Eigen::Matrix3d::Zero();
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
    add(ref, term.weight);
    ofConstants += term.weight * measure.transpose();
  }
  return ofConstants;
}

template <int K>
Vec3 Limit::fittedVector(Index v, const double* form) const {
  std::optional<LinearFit> fit;
  const bool any = addStar<K>(
      v, [&](double scale) { fit.emplace(scale); },
      [&](Index s, const Vec3& measure, const Vec3& offset) {
        fit->add(measure, offset, form[s]);
      });
  return any ? fit->solve() : Vec3::Zero();
}

/// Calls `begin(size of the star)`, then `add(simplex, edge or area vector, offset from the
/// vertex)` for the equations of a least-squares field. @return false when there are none
template <int K, typename Begin, typename Add>
bool Limit::addStar(Index v, const Begin& begin, const Add& add) const {
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
  if (simplices.empty()) return false;
  const Vec3& centre = positions_[v];
  double scale = 0;
  for (const Index cell : cells) {
    scale = std::max(scale, (coefficientPositions_[c_.cellVertex(cell, 0)] - centre).norm());
    scale = std::max(scale, (coefficientPositions_[c_.cellVertex(cell, 1)] - centre).norm());
  }
  begin(scale);
  for (const Index s : simplices) {
    if constexpr (K == 1) {
      const Vec3& a = coefficientPositions_[c_.edges[s][0]];
      const Vec3& b = coefficientPositions_[c_.edges[s][1]];
      add(s, b - a, (a + b) / 2 - centre);
    } else {
      const auto vs = c_.facetVertices(s);
      const Vec3 &p = coefficientPositions_[vs[0]], &q = coefficientPositions_[vs[1]],
                 &r = coefficientPositions_[vs[2]];
      add(s, (q - p).cross(r - p) / 2, (p + q + r) / 3 - centre);
    }
  }
  return true;
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
      const double turn = 2 * kPi * k / n;
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

Array<double> Limit::densities(const Cochain<3>& form, const Context& context) const {
  form.checkOn(c_);
  Array<double> volumes(c_.cellCount());
  parallelFor<Index>(
      c_.cellCount(),
      [&](Index cell) {
        volumes[cell] = c_.cellSigns[cell] * cellVolume6(c_, coefficientPositions_, cell) / 6;
      },
      context);
  Array<double> result(c_.vertexCount());
  reportedFor<Index>(
      c_.vertexCount(),
      [&](Index v) {
        double mass = 0, volume = 0;
        const Index site =
            refiner_.smooth() && masks_.exists[3] ? sites_.siteOfRegular(c_, v) : kNone;
        if (site != kNone) {
          for (const MaskTerm& term : masks_.terms[3]) {
            const LatticeRef ref =
                sites_.cells[sites_.hop(site, term.vertices[0])][term.simplexClass];
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
      },
      context, "limit of densities", "vertices");
  return result;
}

}  // namespace octet
