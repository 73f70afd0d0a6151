// SPDX-License-Identifier: Apache-2.0
#include "patch_test.h"

#include <Eigen/Dense>
#include <algorithm>

#include "../base/parallel.h"
#include "../rules/smoothing_rules.h"
#include "linear_blocks.h"

namespace octet {
namespace {

/// Residuals below this times the largest potential are rounding.
constexpr double kRounding = 1e-14;

/// Condition of the areas' Gram matrix up to which solving with it is as good as with the areas.
constexpr double kGoodGram = 1e3;

/// A symmetric 3x3 matrix as its upper triangle, for fast sums.
using Symmetric = Eigen::Matrix<double, 6, 1>;

Symmetric square(const Vec3& a) {
  Symmetric s;
  s << a[0] * a[0], a[0] * a[1], a[0] * a[2], a[1] * a[1], a[1] * a[2], a[2] * a[2];
  return s;
}

Eigen::Matrix3d full(const Symmetric& s) {
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m;
}

/// L D L^T of a symmetric positive 3x3 matrix.
class Cholesky {
 public:
  explicit Cholesky(const Symmetric& a) {
    d_[0] = a[0];
    l10_ = a[1] / d_[0];
    l20_ = a[2] / d_[0];
    d_[1] = a[3] - l10_ * a[1];
    l21_ = (a[4] - l20_ * a[1]) / d_[1];
    d_[2] = a[5] - l20_ * a[2] - l21_ * l21_ * d_[1];
  }
  /// Ratio of largest to smallest pivot; huge when the matrix is not positive.
  double condition() const {
    const double least = std::min({d_[0], d_[1], d_[2]});
    return least > 0 ? std::max({d_[0], d_[1], d_[2]}) / least : HUGE_VAL;
  }
  Vec3 solve(const Vec3& b) const {
    const double y1 = b[1] - l10_ * b[0];
    const double y2 = b[2] - l20_ * b[0] - l21_ * y1;
    const double x2 = y2 / d_[2];
    const double x1 = y1 / d_[1] - l21_ * x2;
    return {b[0] / d_[0] - l10_ * x1 - l20_ * x2, x1, x2};
  }

 private:
  double d_[3], l10_, l20_, l21_;
};

/// The damped solve on walls: (1 - r^4) / s per singular direction, r = weak / (s + weak).
Vec3 solveDamped(const Eigen::Matrix3d& gram, const Vec3& residual) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram);
  const double weak = kWallDamping * eigen.eigenvalues()[2];
  Vec3 inBasis = eigen.eigenvectors().transpose() * residual;
  for (int k = 0; k < 3; ++k) {
    const double s = std::max(eigen.eigenvalues()[k], 0.0);
    const double r = weak / (s + weak);
    inBasis[k] *= (1 + r + r * r + r * r * r) / (s + weak);
  }
  return eigen.eigenvectors() * inBasis;
}

/// Sums over the facets of a coarse cell's children, of those at its corners and of the others:
/// `onFacet` is what a child on a facet of the cell has, `inside` a facet inside.
template <typename Shape, typename Sum>
struct ChildSums {
  static constexpr int kInner = Shape::kVertices == 4 ? 1 : 8;
  Sum corner[Shape::kVertices], inner[kInner];

  ChildSums(const CellKernel<Shape>& kernel, const Sum* onFacet, const Sum* inside) {
    for (int i = 0; i < Shape::kVertices; ++i) {
      corner[i] = onFacet[kernel.cornerFacets[i][0]];
      for (int k = 1; k < kernel.kFacetsAtCorner; ++k) {
        corner[i] += onFacet[kernel.cornerFacets[i][k]];
      }
      for (int k = 0; k < kernel.kInsideAtCorner; ++k) {
        corner[i] += inside[kernel.cornerInside[i][k]];
      }
    }
    constexpr bool kTet = Shape::kVertices == 4;
    for (int n = 0; n < kInner; ++n) {
      inner[n] = onFacet[n];
      for (int k = 1; kTet && k < 4; ++k) inner[n] += onFacet[k];
      for (int k = 0; k < (kTet ? 4 : 3); ++k) inner[n] += inside[kernel.innerInside[n][k]];
    }
  }
};

/// 1/2 x_a x x_b on an edge, a component of the potential of constant fluxes.
double potential(const Array<Vec3>& x, const Vec3& origin, const std::array<Index, 2>& edge,
                 int axis) {
  const Vec3 a = x[edge[0]] - origin, b = x[edge[1]] - origin;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  return (a[i] * b[j] - a[j] * b[i]) / 2;
}

/// Facets of the cells around an edge, ascending, with repetitions.
std::vector<Index> facetsOfCellsAround(const Complex& complex, Index edge) {
  std::vector<Index> facets;
  complex.visitEdgeStar(edge, [&](const CellAtEdge& at) {
    for (int k = 0; k < complex.cellFacetCount(at.cell); ++k) {
      facets.push_back(complex.cellFacet(at.cell, k).index());
    }
  });
  std::sort(facets.begin(), facets.end());
  return facets;
}

}  // namespace

Array<Vec3> patchTestResiduals(const Complex& fine, const RefineEdges& refine,
                               const Array<Vec3>& oldPositions, const Array<Vec3>& newPositions) {
  const Complex& coarse = *fine.coarse;
  // Potentials are quadratic in positions: measured from the middle they lose fewest digits.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : oldPositions) middle += p / static_cast<double>(oldPositions.size());
  Array<Vec3> residuals(fine.edgeCount());
  Array<double> before(coarse.edgeCount()), after(fine.edgeCount());
  double scale = 0;
  for (int axis = 0; axis < 3; ++axis) {
    parallelFor<Index>(coarse.edgeCount(), [&](Index e) {
      before[e] = potential(oldPositions, middle, coarse.edges[e], axis);
    });
    refine(before.data(), after.data());
    parallelFor<Index>(fine.edgeCount(), [&](Index e) {
      const double there = potential(newPositions, middle, fine.edges[e], axis);
      residuals[e][axis] = after[e] - there;
      after[e] = there;
    });
    for (const double u : after) scale = std::max(scale, std::abs(u));
  }
  parallelFor<Index>(fine.edgeCount(), [&](Index e) {
    if (!(residuals[e].cwiseAbs().maxCoeff() > kRounding * scale)) residuals[e].setZero();
  });
  return residuals;
}

std::vector<Index> facetsAround(const Complex& complex, Index edge) {
  std::vector<Index> facets = facetsOfCellsAround(complex, edge);
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  return facets;
}

/// Sets a patch test up; holds what is needed only for that.
class PatchTest::Builder {
 public:
  explicit Builder(PatchTest* test)
      : t_(*test), f_(t_.f_), c_(t_.c_), children_(c_.children()), kernels_(t_.kernels_) {}

  void run(const RefineEdges& refine, ScratchPool* scratch, const Array<Vec3>& oldPositions,
           const Array<Vec3>& newPositions) {
    // Residuals are left in the multipliers' place.
    t_.multipliers_ = patchTestResiduals(f_, refine, oldPositions, newPositions);
    if (std::all_of(t_.multipliers_.begin(), t_.multipliers_.end(),
                    [](const Vec3& residual) { return residual.isZero(0); })) {
      t_.multipliers_ = {};
      return;
    }
    scratch->clear();
    measureAreas(oldPositions);
    findDoubleNeighbours();
    solve();
  }

 private:
  /// Area vectors of the coarse facets, by linear refinement those of the facets inside coarse
  /// cells, and each fine cell's sum of A A^T.
  void measureAreas(const Array<Vec3>& positions) {
    t_.coarseAreas_.resize(c_.facetCount());
    parallelFor<Index>(c_.facetCount(), [&](Index f) {
      const auto v = c_.facetVertices(f);
      t_.coarseAreas_[f] =
          (positions[v[1]] - positions[v[0]]).cross(positions[v[2]] - positions[v[0]]) / 2;
    });
    insideAreas_.resize(children_.insideNumber(f_.facetCount()));
    cellGrams_.resize(f_.cellCount());
    parallelFor<Index>(c_.tetCount(), [&](Index t) {
      measureCell(kernels_.tet, t, &insideAreas_[children_.insideNumber(children_.inTet(t, 0))]);
    });
    parallelFor<Index>(c_.octCount(), [&](Index o) {
      measureCell(kernels_.oct, c_.tetCount() + o,
                  &insideAreas_[children_.insideNumber(children_.inOct(o, 0))]);
    });
  }

  template <typename Shape>
  void measureCell(const CellKernel<Shape>& kernel, Index cell, Vec3* inside) {
    Vec3 coarse[Shape::kFacets];
    Symmetric onFacet[Shape::kFacets];
    for (int k = 0; k < Shape::kFacets; ++k) {
      const FacetRef f = localFacet<Shape>(c_, cell, k);
      coarse[k] = f.sign() * t_.coarseAreas_[f.index()];
      onFacet[k] = square(coarse[k]) / 16;
    }
    Symmetric insideGram[SplitTables<Shape>::kInside];
    for (int n = 0; n < SplitTables<Shape>::kInside; ++n) {
      inside[n].setZero();
      for (int k = 0; k < Shape::kFacets; ++k) inside[n] += kernel.insideFacet[n][k] * coarse[k];
      insideGram[n] = square(inside[n]);
    }
    const ChildSums<Shape, Symmetric> sums(kernel, onFacet, insideGram);
    for (int i = 0; i < Shape::kVertices; ++i) {
      cellGrams_[children_.cornerChild(cell, i)] = sums.corner[i];
    }
    for (int n = 0; n < sums.kInner; ++n) {
      cellGrams_[children_.innerChild(cell, n)] = sums.inner[n];
    }
  }

  Vec3 area(Index fineFacet) const {
    const ChildOf child = children_.facet(fineFacet);
    return child.origin == Origin::Facet ? Vec3(t_.coarseAreas_[child.parent] / 4)
                                         : insideAreas_[children_.insideNumber(fineFacet)];
  }

  /// Coarse cells that share two facets with one neighbour (a cell in the notch of a non-convex
  /// octahedron), and what is counted twice around the edges between their children.
  void findDoubleNeighbours() {
    std::vector<Index> edges;
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      Index others[8];
      bool doubled = false;
      for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
        others[k] = kNone;
        for (const CellSide& side : c_.facetCells[c_.cellFacet(cell, k).index()]) {
          if (side.exists() && side.cell() != cell) others[k] = side.cell();
        }
        for (int j = 0; j < k; ++j) doubled |= others[k] != kNone && others[j] == others[k];
      }
      if (!doubled) continue;
      const auto add = [&](const auto& closure) {
        edges.insert(edges.end(), closure.index.begin(), closure.index.end());
      };
      if (c_.isTet(cell)) {
        add(ClosureEdges<Tetrahedron>(c_, cell));
      } else {
        add(ClosureEdges<Octahedron>(c_, cell));
      }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (const Index e : edges) {
      const std::vector<Index> facets = facetsOfCellsAround(f_, e);
      for (std::size_t k = 1; k < facets.size(); ++k) {
        if (facets[k] == facets[k - 1] && !facetHasEdge(f_, facets[k], e)) {
          t_.countedTwice_.emplace_back(e, children_.facet(facets[k]).parent);
        }
      }
    }
  }

  void solve() {
    // Wall rows first: they use the residuals, which the multipliers then replace.
    t_.wallMultipliers_.resize(t_.boundary_.edges.size());
    parallelFor<Index>(t_.boundary_.edgeCount(), [&](Index k) {
      const Vec3& residual = t_.multipliers_[t_.boundary_.edges[k]];
      t_.wallMultipliers_[k].setZero();
      if (residual.isZero(0)) return;
      Symmetric gram = Symmetric::Zero();
      t_.visitWallFacets(t_.boundary_.edges[k], [&](Index f) { gram += square(area(f)); });
      t_.wallMultipliers_[k] = solveDamped(full(gram), residual);
    });
    solveHalves();
    solveCuts();
    solveSpokes();
  }

  /// @param gram  sum of A A^T over the facets of the edge's cells, those at the edge once.
  void solveEdge(Index edge, Symmetric gram) {
    Vec3& lambda = t_.multipliers_[edge];
    if (lambda.isZero(0)) return;
    const auto& twice = t_.countedTwice_;
    for (auto it = std::lower_bound(twice.begin(), twice.end(), std::pair{edge, Index{0}});
         it != twice.end() && it->first == edge; ++it) {
      gram -= square(t_.coarseAreas_[it->second]) / 16;
    }
    lambda = solveExactly(edge, gram, lambda);
  }

  // Sums of A A^T over the facets around an edge, from those of its cells: facets at the edge are
  // in two of its cells, all others in one.

  void solveHalves() {
    parallelFor<Index>(c_.edgeCount(), [&](Index e) {
      Symmetric gram[2] = {Symmetric::Zero(), Symmetric::Zero()};
      c_.visitEdgeStar(e, [&](const CellAtEdge& at) {
        const int k = c_.isTet(at.cell) ? kCellTables<Tetrahedron>.edgeBetween[at.start][at.end]
                                        : kCellTables<Octahedron>.edgeBetween[at.start][at.end];
        const auto& where = c_.isTet(at.cell) ? kCellTables<Tetrahedron>.edgeFacets[k]
                                              : kCellTables<Octahedron>.edgeFacets[k];
        Symmetric shared = Symmetric::Zero();
        for (const EdgeInFacet& w : where) {
          const Index f = c_.cellFacet(at.cell, w.facet).index();
          if (!c_.facetOnBoundary(f)) shared += square(t_.coarseAreas_[f]) / 32;
        }
        gram[0] += cellGrams_[children_.cornerChild(at.cell, at.start)] - shared;
        gram[1] += cellGrams_[children_.cornerChild(at.cell, at.end)] - shared;
      });
      for (int end = 0; end < 2; ++end) solveEdge(children_.half(e, end), gram[end]);
    });
  }

  void solveCuts() {
    parallelFor<Index>(c_.facetCount(), [&](Index f) {
      Symmetric gram[3] = {Symmetric::Zero(), Symmetric::Zero(), Symmetric::Zero()};
      const Symmetric onFacet = square(t_.coarseAreas_[f]) / 16;
      for (const CellSide& side : c_.facetCells[f]) {
        if (!side.exists()) continue;
        const Index cell = side.cell();
        const FacetRef seen = c_.cellFacet(cell, side.facet());
        const bool tet = c_.isTet(cell);
        const auto& triple =
            tet ? Tetrahedron::facets[side.facet()] : Octahedron::facets[side.facet()];
        for (int s = 0; s < 3; ++s) {
          const Index inside =
              tet ? children_.inTet(cell, kernels_.tet.insideAtCut[side.facet()][s])
                  : children_.inOct(cell - c_.tetCount(),
                                    kernels_.oct.insideAtCut[side.facet()][s]);
          Symmetric& sum = gram[seen.place(s)];
          sum += cellGrams_[children_.cornerChild(cell, triple[s])] +
                 cellGrams_[children_.innerChild(cell, side.facet())] - square(area(inside));
          if (!c_.facetOnBoundary(f)) sum -= onFacet;
        }
      }
      for (int s = 0; s < 3; ++s) solveEdge(children_.cut(f, s), gram[s]);
    });
  }

  void solveSpokes() {
    parallelFor<Index>(c_.octCount(), [&](Index o) {
      for (int k = 0; k < 12; ++k) {
        Symmetric gram = Symmetric::Zero();
        for (const int i : Octahedron::edges[k]) gram += cellGrams_[children_.cornerOct(o, i)];
        for (const EdgeInFacet& where : kCellTables<Octahedron>.edgeFacets[k]) {
          gram += cellGrams_[children_.innerTet(o, where.facet)];
        }
        for (const int n : kernels_.oct.insideAtSpoke[k]) {
          gram -= square(area(children_.inOct(o, n)));
        }
        solveEdge(children_.spoke(o, k), gram);
      }
    });
  }

  /// lambda with (A A^T) lambda = r, A the area vectors around an edge as columns. Where cells are
  /// flat the product loses digits that a QR factorisation of A^T keeps.
  Vec3 solveExactly(Index edge, const Symmetric& gram, const Vec3& residual) const {
    const Cholesky factors(gram);
    if (factors.condition() < kGoodGram) {
      const Vec3 first = factors.solve(residual);
      return first + factors.solve(residual - full(gram) * first);
    }
    const std::vector<Index> facets = facetsAround(f_, edge);
    Eigen::MatrixX3d areas(static_cast<Eigen::Index>(facets.size()), 3);
    for (std::size_t k = 0; k < facets.size(); ++k) {
      areas.row(static_cast<Eigen::Index>(k)) = area(facets[k]);
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(areas);
    if (qr.rank() < 3) return full(gram).completeOrthogonalDecomposition().solve(residual);
    const Eigen::Matrix3d factor = qr.matrixR().topRows<3>();
    const auto upper = factor.triangularView<Eigen::Upper>();
    const Vec3 permuted = qr.colsPermutation().transpose() * residual;
    return qr.colsPermutation() * Vec3(upper.solve(upper.transpose().solve(permuted)));
  }

  PatchTest& t_;
  const Complex& f_;
  const Complex& c_;
  const ChildNumbering children_;
  const CellKernels& kernels_;
  Array<Vec3> insideAreas_;     // of fine facets inside coarse cells
  Array<Symmetric> cellGrams_;  // sums of A A^T over the facets of fine cells
};

PatchTest::PatchTest(const Complex& fine, const Boundary& boundary, const CellKernels& kernels,
                     const RefineEdges& refine, ScratchPool* scratch,
                     const Array<Vec3>& oldPositions, const Array<Vec3>& newPositions)
    : c_(*fine.coarse), f_(fine), boundary_(boundary), kernels_(kernels) {
  Builder(this).run(refine, scratch, oldPositions, newPositions);
}

Vec3 PatchTest::area(Index fineFacet) const {
  Vec3 sum = Vec3::Zero();
  linearRow<2>(c_, kernels_.linear, fineFacet, 1,
               [&](Index f, double w) { sum += w * coarseAreas_[f]; });
  return sum;
}

template <typename Shape>
void PatchTest::addCell(Index cell, const double* facets, const ClosureEdges<Shape>& closure,
                        double* values) const {
  const CellKernel<Shape>& kernel = kernels_.of<Shape>();
  using Edges = FineEdges<Shape>;
  constexpr bool kTet = Shape::kVertices == 4;
  constexpr int kInside = SplitTables<Shape>::kInside;
  // Area and flux side by side; a child of one of the cell's facets has a quarter of both.
  Eigen::Vector4d coarse[Shape::kFacets];
  Eigen::Vector4d onFacet[Shape::kFacets];
  bool interior[Shape::kFacets];
  for (int k = 0; k < Shape::kFacets; ++k) {
    const FacetRef f = c_.cellFacet(cell, k);
    coarse[k] << f.sign() * coarseAreas_[f.index()], facets[k];
    onFacet[k] = coarse[k] * (facets[k] / 16);
    interior[k] = !c_.facetOnBoundary(f.index());
  }
  Eigen::Vector4d inside[kInside];  // first three: A_f times the flux through f
  for (int n = 0; n < kInside; ++n) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int k = 0; k < Shape::kFacets; ++k) sum += kernel.insideFacet[n][k] * coarse[k];
    inside[n] = sum * sum[3];
  }
  const ChildSums<Shape, Eigen::Vector4d> sums(kernel, onFacet, inside);
  const auto& corner = sums.corner;
  const auto& inner = sums.inner;
  const auto add = [&](int at, const Eigen::Vector4d& sum) {
    values[at] += multipliers_[closure.index[at]].dot(sum.head<3>());
  };
  // Facets at an edge are shared by two of its cells: half belongs to each.
  for (int k = 0; k < Shape::kEdges; ++k) {
    Eigen::Vector4d shared = Eigen::Vector4d::Zero();
    for (const EdgeInFacet& where : kCellTables<Shape>.edgeFacets[k]) {
      if (interior[where.facet]) shared += onFacet[where.facet] / 2;
    }
    for (int end = 0; end < 2; ++end) {
      add(Edges::half(k, end), corner[Shape::edges[k][end]] - shared);
    }
  }
  for (int f = 0; f < Shape::kFacets; ++f) {
    for (int s = 0; s < 3; ++s) {
      Eigen::Vector4d sum =
          corner[Shape::facets[f][s]] + inner[kTet ? 0 : f] - inside[kernel.insideAtCut[f][s]];
      if (interior[f]) sum -= onFacet[f];
      add(Edges::cut(f, s), sum);
    }
  }
  if constexpr (!kTet) {
    for (int k = 0; k < 12; ++k) {
      Eigen::Vector4d sum = corner[Shape::edges[k][0]] + corner[Shape::edges[k][1]];
      for (const EdgeInFacet& where : kCellTables<Shape>.edgeFacets[k]) sum += inner[where.facet];
      for (const int n : kernel.insideAtSpoke[k]) sum -= inside[n];
      add(Edges::spoke(k), sum);
    }
  }
}

template void PatchTest::addCell(Index, const double*, const ClosureEdges<Tetrahedron>&,
                                 double*) const;
template void PatchTest::addCell(Index, const double*, const ClosureEdges<Octahedron>&,
                                 double*) const;

void PatchTest::finish(BoundaryMode mode, const double* coarseFacets, double* edges) const {
  // Children of a coarse facet have a quarter of its area and of its flux.
  const ChildNumbering children = c_.children();
  const auto ofParent = [&](Index f) -> Vec3 { return coarseAreas_[f] * (coarseFacets[f] / 16); };
  for (const auto& [e, f] : countedTwice_) edges[e] -= multipliers_[e].dot(ofParent(f));
  if (mode == BoundaryMode::Open) return;
  parallelFor<Index>(boundary_.edgeCount(), [&](Index k) {
    Vec3 sum = Vec3::Zero();
    visitWallFacets(boundary_.edges[k],
                    [&](Index f) { sum += ofParent(children.facet(f).parent); });
    edges[boundary_.edges[k]] = wallMultipliers_[k].dot(sum);
  });
}

}  // namespace octet
