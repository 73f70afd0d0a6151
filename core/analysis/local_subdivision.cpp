// SPDX-License-Identifier: Apache-2.0
#include "local_subdivision.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "../base/sort_unique.h"
#include "../refine/step_adjoint.h"
#include "../topology/split.h"
#include "dense_algebra.h"

namespace octet {
namespace {

/// The star's shape has settled when a step leaves its coordinates' span up to this.
constexpr double kSettled = 1e-14;
constexpr int kMostSettlingSteps = 2000;

/// A fine simplex in the place of a coarse one, and whether their stored orientations agree.
struct Place {
  Index fine = kNone;
  double sign = 1;
};

/// Simplices of the fine star of a vertex in the places of those of its coarse star.
template <int K>
std::vector<Place> places(const Complex& coarse, const Complex& fine, Index centre) {
  std::vector<Place> result(static_cast<std::size_t>(coarse.count(K)));
  coarse.visitVertexStar(centre, [&](const CellAtVertex& at) {
    const Index child = coarse.children().cornerChild(at.cell, at.place);
    const int n = coarse.cellVertexCount(at.cell);
    if constexpr (K == 2) {
      for (int k = 0; k < coarse.cellFacetCount(at.cell); ++k) {
        const FacetRef from = coarse.cellFacet(at.cell, k), to = fine.cellFacet(child, k);
        result[from.index()] = {to.index(), from.sign() * to.sign()};
      }
    } else {
      for (int i = 0; i < n; ++i) {
        if (K == 0) result[coarse.cellVertex(at.cell, i)] = {fine.cellVertex(child, i), 1};
        for (int j = i + 1; j < n && K == 1; ++j) {
          if (n == 6 && Octahedron::opposite[i] == j) continue;
          const EdgeRef from = coarse.cellEdge(at.cell, i, j), to = fine.cellEdge(child, i, j);
          result[from.index()] = {to.index(), from.sign() * to.sign()};
        }
      }
    }
  });
  return result;
}

/// Centre at the origin, spread 1 in all directions: what an affine map can undo.
Eigen::MatrixXd normalised(Eigen::MatrixXd x, Index centre) {
  const Eigen::RowVectorXd origin = x.row(centre);
  x.rowwise() -= origin;
  const Eigen::Matrix3d spread = x.transpose() * x / static_cast<double>(x.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  return x * eigen.operatorInverseSqrt();
}

}  // namespace

/// @brief The star one level further in, where nothing around it is cut off or irregular on its
/// own account, and the step from there: the same as at every finer level.
class LocalSubdivision::Generic {
 public:
  Generic(const ControlMesh& star, Index centre, const LocalSubdivisionOptions& options)
      : centre_(centre),
        options_(options),
        linear_(options.zeta),
        kernels_(options.zeta),
        control_(star.complex()),
        coarse_(split(control_)),
        fine_(split(coarse_)) {
    const Boundary control(*control_, star.corners(), nullptr);
    coarseBoundary_ = Boundary(*coarse_, star.corners(), &control);
    boundary_ = Boundary(*fine_, star.corners(), &coarseBoundary_);
    sites_ = LatticeSites(*fine_);
    smoothing_ = std::make_unique<Smoothing>(*fine_, boundary_, coarseBoundary_, sites_, kernels_,
                                             &scratch_, options.boundaryRows);
    smoothing_->moveAll();
  }

  /// Gives the star the positions that the patch test is to look at.
  void place(const Array<Vec3>& positions) {
    Array<Vec3> before(coarse_->vertexCount(), Vec3::Zero()), after(fine_->vertexCount());
    const auto vertices = places<0>(*control_, *coarse_, centre_);
    for (std::size_t v = 0; v < vertices.size(); ++v) before[vertices[v].fine] = positions[v];
    Array<double> in(before.size()), middle(after.size()), out(after.size());
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t v = 0; v < before.size(); ++v) in[v] = before[v][axis];
      linear_.apply0(*coarse_, in.data(), middle.data());
      smoothing_->apply0(in.data(), middle.data(), out.data());
      for (std::size_t v = 0; v < after.size(); ++v) after[v][axis] = out[v];
    }
    Array<double> edges(fine_->edgeCount());
    const auto uncorrected = [&](const double* from, double* to) {
      linear_.apply1(*coarse_, from, edges.data());
      smoothing_->apply1(from, edges.data(), {}, to);
    };
    patchTest_ = std::make_unique<PatchTest>(*fine_, boundary_, kernels_, uncorrected, &scratch_,
                                             before, after);
  }

  template <int K>
  Eigen::MatrixXd matrix() const {
    const StepAdjoint step(*fine_, sites_, kernels_.linear, smoothing_.get(),
                           {patchTest_.get(), options_.mode});
    const auto columns = places<K>(*control_, *coarse_, centre_);
    const auto rows = places<K>(*coarse_, *fine_, centre_);
    std::vector<Index> columnOf(static_cast<std::size_t>(coarse_->count(K)), kNone);
    for (std::size_t s = 0; s < columns.size(); ++s) {
      columnOf[columns[s].fine] = static_cast<Index>(s);
    }
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(control_->count(K), control_->count(K));
    RowSum sum(coarse_->count(K));
    for (std::size_t s = 0; s < columns.size(); ++s) {
      const Place& place = rows[columns[s].fine];
      const double sign = columns[s].sign * place.sign;
      if constexpr (K == 0) step.addVertex(place.fine, sign, &sum);
      if constexpr (K == 1) step.addEdge(place.fine, sign, &sum);
      if constexpr (K == 2) step.addFacet(place.fine, sign, &sum);
      const SparseRow row = sum.take();
      for (std::size_t k = 0; k < row.size(); ++k) {
        const Index column = columnOf[row.index[k]];
        if (column == kNone) continue;
        result(static_cast<Eigen::Index>(s), column) = row.weight[k] * columns[column].sign;
      }
    }
    return result;
  }

 private:
  Index centre_;
  LocalSubdivisionOptions options_;
  LinearRefinement linear_;
  CellKernels kernels_;
  ScratchPool scratch_;
  std::shared_ptr<const Complex> control_, coarse_, fine_;
  Boundary coarseBoundary_, boundary_;
  LatticeSites sites_;
  std::unique_ptr<Smoothing> smoothing_;
  std::unique_ptr<PatchTest> patchTest_;
};

LocalSubdivision::LocalSubdivision(const Refiner& refiner, int level, Index vertex,
                                   const LocalSubdivisionOptions& options)
    : options_(options) {
  cutOut(refiner, level, vertex);
  generic_ = std::make_unique<Generic>(ControlMesh::build(input_), centre_, options_);
  if (options.settle) settle();
  const ControlMesh mesh = ControlMesh::build(input_);
  star_ = mesh.complex();
  positions_ = mesh.positions();
  if (options.patchTest) generic_->place(positions_);
}

LocalSubdivision::~LocalSubdivision() = default;
LocalSubdivision::LocalSubdivision(LocalSubdivision&&) noexcept = default;

void LocalSubdivision::cutOut(const Refiner& refiner, int level, Index vertex) {
  if (level < 0 || level > refiner.levels()) {
    throw InputError("level", std::to_string(level) + " is not between 0 and " +
                                  std::to_string(refiner.levels()));
  }
  const Complex& c = refiner.complex(level);
  if (vertex < 0 || vertex >= c.vertexCount()) {
    throw InputError("vertex", std::to_string(vertex) + " is out of range, level " +
                                   std::to_string(level) + " has " +
                                   std::to_string(c.vertexCount()) + " vertices");
  }
  type_ = c.vertexTypes[vertex];
  std::vector<Index> cells;
  c.visitVertexStar(vertex, [&](const CellAtVertex& at) { cells.push_back(at.cell); });
  if (cells.empty()) {
    throw InputError("vertex", std::to_string(vertex) + " belongs to no cell");
  }
  std::sort(cells.begin(), cells.end());
  for (const Index cell : cells) {
    for (int i = 0; i < c.cellVertexCount(cell); ++i) vertices_.push_back(c.cellVertex(cell, i));
  }
  sortUnique(&vertices_);
  const auto local = [&](Index v) {
    return static_cast<Index>(std::lower_bound(vertices_.begin(), vertices_.end(), v) -
                              vertices_.begin());
  };
  for (const Index cell : cells) {
    input_.cellRegions.push_back(c.cellRegions[cell]);
    input_.cellFrames.push_back(c.cellFrames[cell]);
  }
  for (const Index v : vertices_) input_.vertices.push_back(refiner.positions(level)[v]);
  for (const Index cell : cells) {
    if (c.isTet(cell)) {
      auto& tet = input_.tets.emplace_back();
      for (int i = 0; i < 4; ++i) tet[i] = local(c.cellVertex(cell, i));
    } else {
      auto& oct = input_.octs.emplace_back();
      for (int i = 0; i < 6; ++i) oct[i] = local(c.cellVertex(cell, i));
    }
  }
  centre_ = local(vertex);
  // The boundary's own features at the vertex; what the cut makes boundary is smooth.
  input_.creases.emplace();
  const Boundary& boundary = refiner.boundary(level);
  const Index row = boundary.row(vertex);
  if (row == kNone) return;
  for (const RingStep* step = boundary.ringBegin(row); step != boundary.ringEnd(row); ++step) {
    const Index e = step->edge.index();
    if (!step->firstOfEdge || !(c.edgeFlags[e] & kOnCrease)) continue;
    input_.creases->push_back({local(c.edges[e][0]), local(c.edges[e][1])});
  }
  if (boundary.kinds[row] == BoundaryKind::Corner) input_.corners.push_back(centre_);
}

void LocalSubdivision::settle() {
  const Eigen::MatrixXd step = matrix<0>();
  Eigen::MatrixXd x(input_.vertices.size(), 3);
  for (std::size_t v = 0; v < input_.vertices.size(); ++v) {
    x.row(static_cast<Eigen::Index>(v)) = input_.vertices[v];
  }
  x = normalised(x, centre_);
  for (int k = 0; k < kMostSettlingSteps; ++k) {
    const Eigen::MatrixXd next = normalised(step * x, centre_);
    const double left = (next - x * leastSquares(x, next)).norm() / next.norm();
    x = next;
    if (left < kSettled) break;
  }
  for (std::size_t v = 0; v < input_.vertices.size(); ++v) {
    input_.vertices[v] = x.row(static_cast<Eigen::Index>(v));
  }
}

template <int K>
Eigen::MatrixXd LocalSubdivision::matrix() const {
  static_assert(K >= 0 && K <= 2, "masses are refined cell by cell");
  return generic_->matrix<K>();
}

template <int K>
Eigen::MatrixXd LocalSubdivision::constants() const {
  Eigen::MatrixXd result(star_->count(K), 3);
  for (Index s = 0; s < star_->count(K); ++s) {
    if constexpr (K == 1) {
      const auto& [a, b] = star_->edges[s];
      result.row(s) = positions_[b] - positions_[a];
    } else {
      const auto [a, b, c] = star_->facetVertices(s);
      result.row(s) = (positions_[b] - positions_[a]).cross(positions_[c] - positions_[a]) / 2;
    }
  }
  return result;
}

template Eigen::MatrixXd LocalSubdivision::matrix<0>() const;
template Eigen::MatrixXd LocalSubdivision::matrix<1>() const;
template Eigen::MatrixXd LocalSubdivision::matrix<2>() const;
template Eigen::MatrixXd LocalSubdivision::constants<1>() const;
template Eigen::MatrixXd LocalSubdivision::constants<2>() const;

}  // namespace octet
