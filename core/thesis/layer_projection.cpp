// SPDX-License-Identifier: Apache-2.0
#include "layer_projection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

#include "../base/parallel.h"
#include "../base/sort_unique.h"

namespace octet {
namespace {

/// Normals of a boundary vertex' facets spread over directions; those with less than this of the
/// largest share are roundness, not another wall.
constexpr double kSameWall = 0.15;
/// Quadratic parts are fitted when there are this many times as many coefficients as unknowns.
constexpr int kOverdetermined = 2;
/// Parts whose coefficients are this small, relative to the largest, are left out: on an irregular
/// layer they would take up what is no quadratic field and grow from level to level.
constexpr double kHardlyTold = 0.05;

constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};

Cochain<0> refined(const Refiner& refiner, int level, const Cochain<0>& form) {
  return refiner.step(level, form, BoundaryMode::Walls);
}

}  // namespace

LayerProjection::LayerProjection(const Refiner& refiner, int level, const Array<Vec3>& positions)
    : refiner_(refiner),
      c_(refiner.complex(level)),
      f_(refiner.complex(level + 1)),
      boundary_(refiner.boundary(level)),
      level_(level),
      x_(positions),
      origin_(Vec3::Zero()) {
  for (const Vec3& p : x_) origin_ += p / static_cast<double>(x_.size());
  findLayers();
  placeVertices();
  coarseMonomials_.resize(c_.vertexCount());
  fineMonomials_.resize(f_.vertexCount());
  for (int m = 0; m < kMonomials; ++m) {
    Cochain<0> monomial(c_);
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      const Vec3 p = x_[v] - origin_;
      monomial[v] = m < 3 ? p[m] : p[kPairs[m - 3][0]] * p[kPairs[m - 3][1]];
      coarseMonomials_[v][m] = monomial[v];
    }
    Cochain<0> fine = refined(refiner_, level_, monomial);
    correct(monomial, &fine);
    for (Index v = 0; v < f_.vertexCount(); ++v) fineMonomials_[v][m] = fine[v];
  }
}

void LayerProjection::findLayers() {
  layers_.resize(boundary_.vertices.size());
  parallelFor<Index>(
      boundary_.vertexCount(),
      [&](Index row) { layers_[row] = makeLayer(boundary_.vertices[row]); }, 16);
}

LayerProjection::Layer LayerProjection::makeLayer(Index vertex) const {
  Layer layer;
  layer.vertex = vertex;
  layer.size = 0;
  c_.visitVertexStar(vertex, [&](const CellAtVertex& at) {
    for (int k = 0; k < c_.cellFacetCount(at.cell); ++k) {
      layer.facets.push_back(c_.cellFacet(at.cell, k).index());
    }
  });
  sortUnique(&layer.facets);
  for (const Index f : layer.facets) {
    for (const EdgeRef& e : c_.facetEdges[f]) layer.edges.push_back(e.index());
    for (const Index v : c_.facetVertices(f)) layer.vertices.push_back(v);
  }
  sortUnique(&layer.edges);
  sortUnique(&layer.vertices);
  const auto n = static_cast<Eigen::Index>(layer.vertices.size());
  Eigen::MatrixXd offsets(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    offsets.row(k) = x_[layer.vertices[static_cast<std::size_t>(k)]] - x_[vertex];
    layer.size = std::max(layer.size, offsets.row(k).norm());
  }
  // Slope of a function at the vertex from differences to it: exact for linear functions.
  const Eigen::MatrixXd inverse = offsets.completeOrthogonalDecomposition().pseudoInverse();
  layer.gradient = inverse;
  return layer;
}

std::vector<Index> LayerProjection::layersAt(Index fineVertex) const {
  const ChildOf child = c_.children().vertex(fineVertex);
  if (child.origin == Origin::Vertex) return {boundary_.row(fineVertex)};
  const auto& [a, b] = c_.edges[child.parent];
  return {boundary_.row(a), boundary_.row(b)};
}

/// Projection onto the directions along all boundary facets at a fine vertex, as the coarse
/// positions show them.
Eigen::Matrix3d LayerProjection::alongWall(Index fineVertex) const {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  const auto add = [&](Index facet) {
    const auto v = c_.facetVertices(facet);
    const Vec3 area = (x_[v[1]] - x_[v[0]]).cross(x_[v[2]] - x_[v[0]]);
    if (area.norm() > 0) spread += area * area.transpose() / area.norm();
  };
  const ChildOf child = c_.children().vertex(fineVertex);
  const bool kept = child.origin == Origin::Vertex;
  const Index row = boundary_.row(kept ? fineVertex : c_.edges[child.parent][0]);
  for (auto step = boundary_.ringBegin(row); step != boundary_.ringEnd(row); ++step) {
    const auto& edges = c_.facetEdges[step->facet];
    if (kept || std::any_of(edges.begin(), edges.end(),
                            [&](const EdgeRef& e) { return e.index() == child.parent; })) {
      add(step->facet);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  Eigen::Matrix3d projection = Eigen::Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) {
    if (eigen.eigenvalues()[k] > kSameWall * eigen.eigenvalues()[2]) {
      const Vec3 normal = eigen.eigenvectors().col(k);
      projection -= normal * normal.transpose();
    }
  }
  return projection;
}

/// Star rows, then back along the normals to where the linear rule puts the vertex.
void LayerProjection::placeVertices() {
  fineX_.resize(f_.vertexCount());
  for (int axis = 0; axis < 3; ++axis) {
    Cochain<0> coordinate(c_);
    for (Index v = 0; v < c_.vertexCount(); ++v) coordinate[v] = x_[v][axis];
    const Cochain<0> fine = refined(refiner_, level_, coordinate);
    for (Index v = 0; v < f_.vertexCount(); ++v) fineX_[v][axis] = fine[v];
  }
  shift_.assign(f_.vertexCount(), Vec3::Zero());
  const Boundary& fineBoundary = refiner_.boundary(level_ + 1);
  parallelFor<Index>(fineBoundary.vertexCount(), [&](Index row) {
    const Index v = fineBoundary.vertices[row];
    const ChildOf child = c_.children().vertex(v);
    Vec3 linear = x_[child.origin == Origin::Vertex ? v : c_.edges[child.parent][0]];
    if (child.origin == Origin::Edge) linear = (linear + x_[c_.edges[child.parent][1]]) / 2;
    const Vec3 moved = linear - fineX_[v];
    shift_[v] = moved - alongWall(v) * moved;
    fineX_[v] += shift_[v];
  });
}

void LayerProjection::correct(const Cochain<0>& coarse, Cochain<0>* fine) const {
  const Boundary& fineBoundary = refiner_.boundary(level_ + 1);
  parallelFor<Index>(fineBoundary.vertexCount(), [&](Index row) {
    const Index v = fineBoundary.vertices[row];
    const auto at = layersAt(v);
    for (const Index k : at) {
      const Layer& layer = layers_[static_cast<std::size_t>(k)];
      Vec3 slope = Vec3::Zero();
      for (std::size_t i = 0; i < layer.vertices.size(); ++i) {
        slope += layer.gradient.col(static_cast<Eigen::Index>(i)) *
                 (coarse[layer.vertices[i]] - coarse[layer.vertex]);
      }
      (*fine)[v] += slope.dot(shift_[v]) / static_cast<double>(at.size());
    }
  });
}

LayerProjection::Polynomial LayerProjection::local(const Array<Polynomial>& monomials,
                                                   const Layer& layer, Index vertex) const {
  // (x - a)(y - b) = xy - a y - b x + ab; the constant does not matter to differences.
  const Vec3 centre = x_[layer.vertex] - origin_;
  const Polynomial& global = monomials[vertex];
  Polynomial result;
  for (int m = 0; m < 3; ++m) result[m] = (global[m] - centre[m]) / layer.size;
  for (int m = 0; m < 6; ++m) {
    const auto& [i, j] = kPairs[m];
    result[3 + m] =
        (global[3 + m] - centre[i] * global[j] - centre[j] * global[i] + centre[i] * centre[j]) /
        (layer.size * layer.size);
  }
  return result;
}

/// Coefficients of the basis forms on a simplex with potentials given at its corners: for edges
/// d of the monomials, for facets d m ^ d n, by the circulation of m d n around it.
template <int K>
Eigen::RowVectorXd LayerProjection::basis(const std::array<Polynomial, K + 1>& corners) const {
  if constexpr (K == 1) {
    return (corners[1] - corners[0]).transpose();
  } else {
    const Polynomial u = corners[1] - corners[0], v = corners[2] - corners[0];
    Eigen::RowVectorXd result(3 + 18);
    const auto wedge = [&](int m, int n) { return (u[m] * v[n] - u[n] * v[m]) / 2; };
    result[0] = wedge(1, 2);
    result[1] = wedge(2, 0);
    result[2] = wedge(0, 1);
    for (int m = 0; m < 3; ++m) {
      for (int n = 3; n < kMonomials; ++n) result[3 + 6 * m + n - 3] = wedge(m, n);
    }
    return result;
  }
}

template <int K>
Eigen::VectorXd LayerProjection::fit(const Layer& layer, const Cochain<K>& form) const {
  const auto& simplices = K == 1 ? layer.edges : layer.facets;
  const auto n = static_cast<Eigen::Index>(simplices.size());
  Eigen::MatrixXd rows;
  Eigen::VectorXd values(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Index s = simplices[static_cast<std::size_t>(k)];
    std::array<Polynomial, K + 1> corners;
    if constexpr (K == 1) {
      for (int i = 0; i < 2; ++i) corners[i] = local(coarseMonomials_, layer, c_.edges[s][i]);
    } else {
      const auto v = c_.facetVertices(s);
      for (int i = 0; i < 3; ++i) corners[i] = local(coarseMonomials_, layer, v[i]);
    }
    const Eigen::RowVectorXd row = basis<K>(corners);
    if (k == 0) rows.resize(n, row.size());
    rows.row(k) = row;
    values[k] = form[s];
  }
  // Constants first, so that they are exact even where more is not determined.
  Eigen::VectorXd result = Eigen::VectorXd::Zero(rows.cols());
  result.head<3>() = rows.leftCols<3>().completeOrthogonalDecomposition().solve(values);
  const Eigen::Index unknowns = K == 1 ? 9 : 11;  // independent ones, constants included
  if (n < kOverdetermined * unknowns) return result;
  const Eigen::VectorXd rest = values - rows.leftCols<3>() * result.head<3>();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(kHardlyTold);
  solver.compute(rows);
  return result + solver.solve(rest);
}

template <int K>
void LayerProjection::replace(const Cochain<K>& coarse, Cochain<K>* fine) const {
  std::vector<Eigen::VectorXd> fits(layers_.size());
  parallelFor<std::size_t>(
      layers_.size(), [&](std::size_t k) { fits[k] = fit<K>(layers_[k], coarse); }, 16);
  parallelFor<Index>(
      f_.count(K),
      [&](Index s) {
        std::array<Index, K + 1> v;
        if constexpr (K == 1) v = f_.edges[s];
        if constexpr (K == 2) v = f_.facetVertices(s);
        double sum = 0, weight = 0;
        for (const Index vertex : v) {
          if (!f_.vertexOnBoundary(vertex)) continue;
          const auto at = layersAt(vertex);
          for (const Index k : at) {
            const Layer& layer = layers_[static_cast<std::size_t>(k)];
            std::array<Polynomial, K + 1> corners;
            for (int i = 0; i <= K; ++i) corners[i] = local(fineMonomials_, layer, v[i]);
            const double share = 1.0 / static_cast<double>(at.size());
            sum += share * basis<K>(corners).dot(fits[static_cast<std::size_t>(k)]);
            weight += share;
          }
        }
        if (weight > 0) (*fine)[s] = sum / weight;
      },
      256);
}

template void LayerProjection::replace(const Cochain<1>&, Cochain<1>*) const;
template void LayerProjection::replace(const Cochain<2>&, Cochain<2>*) const;

}  // namespace octet
