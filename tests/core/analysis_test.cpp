// SPDX-License-Identifier: Apache-2.0
// Eigenanalysis of the subdivision around a vertex (thesis 4.3.1): the tables of SCHEME.md section
// 5, what depends on zeta, vertices of every type, and what that says about continuity.
#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include <octet/core/analysis/continuity.h>
#include <octet/core/analysis/local_subdivision.h>
#include <octet/core/analysis/spectrum.h>
#include <octet/core/base/numbers.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

using Expected = std::vector<std::pair<double, int>>;

Refiner refined(const ControlMeshInput& input, int levels, double zeta = kDefaultZeta,
                BoundaryRows rows = BoundaryRows::Smooth) {
  RefinerOptions options;
  options.boundaryRows = rows;
  options.levels = levels;
  options.zeta = zeta;
  return Refiner(ControlMesh::build(input), options);
}

Index firstOfType(const Complex& complex, VertexType type) {
  const auto& types = complex.vertexTypes;
  const auto found = std::find(types.begin(), types.end(), type);
  return found == types.end() ? kNone : static_cast<Index>(found - types.begin());
}

void expectSpectrum(const std::vector<Eigenvalue>& actual, Expected expected) {
  std::sort(expected.rbegin(), expected.rend());
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(actual[k].value.real(), expected[k].first, 1e-9);
    EXPECT_EQ(actual[k].value.imag(), 0);
    EXPECT_EQ(actual[k].multiplicity, expected[k].second) << "of " << expected[k].first;
  }
}

LocalSubdivision regularVertex(double zeta) {
  const Refiner refiner = refined(testing::regularOneRing(), 0);
  LocalSubdivisionOptions options;
  options.zeta = zeta;
  return LocalSubdivision(refiner, 0, firstOfType(refiner.complex(0), VertexType::R), options);
}

TEST(Spectrum, OfTheRegularOneRingIsThatOfTheTable) {
  const LocalSubdivision local = regularVertex(kDefaultZeta);
  ASSERT_EQ(local.star().vertexCount(), 19);
  ASSERT_EQ(local.star().edgeCount(), 60);
  ASSERT_EQ(local.star().facetCount(), 56);
  expectSpectrum(spectrum(local.matrix<0>()),
                 {{1, 1}, {1. / 2, 3}, {1. / 4, 6}, {1. / 8, 6}, {5. / 48, 1}, {1. / 12, 2}});
  expectSpectrum(spectrum(local.matrix<1>()), {{1. / 2, 3},
                                               {1. / 4, 9},
                                               {1. / 8, 17},
                                               {5. / 48, 1},
                                               {1. / 12, 2},
                                               {1. / 16, 16},
                                               {3. / 64, 3},
                                               {7. / 192, 3},
                                               {1. / 32, 4},
                                               {1. / 48, 2}});
  expectSpectrum(spectrum(local.matrix<2>()), {{1. / 4, 3},
                                               {1. / 8, 12},
                                               {1. / 16, 20},
                                               {3. / 64, 3},
                                               {7. / 192, 3},
                                               {1. / 32, 10},
                                               {1. / 48, 2},
                                               {1. / 64, 3}});
}

TEST(Spectrum, EighteenEigenvaluesDependOnZeta) {
  // p = (zeta + 6) / 8 three times, p/2 nine, 3p/8 and 7p/24 three times each, in both degrees; the
  // others stay. Values of zeta at which no p-multiple meets another eigenvalue.
  for (const double zeta : {-4.3, -5.37, -6.61, -7.9, -2.1}) {
    SCOPED_TRACE(zeta);
    const double p = (zeta + 6) / 8;
    const LocalSubdivision local = regularVertex(zeta);
    const auto split = [&](const Eigen::MatrixXd& matrix) {
      int found = 0;
      for (const Eigenvalue& value : spectrum(matrix, false)) {
        for (const auto& [multiple, count] :
             Expected{{p, 3}, {p / 2, 9}, {3 * p / 8, 3}, {7 * p / 24, 3}}) {
          if (std::abs(value.value - multiple) > 1e-9) continue;
          EXPECT_EQ(value.multiplicity, count) << "of " << multiple;
          found += value.multiplicity;
        }
      }
      return found;
    };
    EXPECT_EQ(split(local.matrix<1>()), 18);
    EXPECT_EQ(split(local.matrix<2>()), 18);
  }
}

TEST(Spectrum, LeftEigenvectorsAreTheLimitMasks) {
  const LocalSubdivision local = regularVertex(kDefaultZeta);
  const auto values = spectrum(local.matrix<0>());
  const Eigenvalue& one = values.front();
  ASSERT_EQ(one.left.rows(), 1);
  // SCHEME.md section 5: 16/43 at the vertex, 19/387 at 12 neighbours, 5/774 at 6.
  const Eigen::VectorXd mask = (one.left * one.forms(0, 0)).real().transpose();
  const double scale = 1 / mask.sum();
  for (Index v = 0; v < local.star().vertexCount(); ++v) {
    const double distance = local.positions()[v].norm() / local.positions()[0].norm();
    const double weight = scale * mask[v];
    const bool listed = std::abs(weight - 16. / 43) < 1e-12 ||
                        std::abs(weight - 19. / 387) < 1e-12 || std::abs(weight - 5. / 774) < 1e-12;
    EXPECT_TRUE(listed) << weight << " at distance " << distance;
  }
  EXPECT_NEAR(scale * mask[local.centre()], 16. / 43, 1e-12);
}

TEST(Spectrum, EigenformsAndLeftEigenvectorsSolveTheirEquations) {
  const Refiner refiner = refined(testing::randomBall(60, 3), 0);
  const Index vertex = firstOfType(refiner.complex(0), VertexType::X3);
  ASSERT_NE(vertex, kNone);
  const LocalSubdivision local(refiner, 0, vertex);
  const Eigen::MatrixXd matrix = local.matrix<1>();
  int total = 0;
  for (const Eigenvalue& value : spectrum(matrix)) {
    total += value.multiplicity;
    EXPECT_LT((matrix * value.forms - value.value * value.forms).norm(), 1e-7);
    EXPECT_LT((value.left * matrix - value.value * value.left).norm(), 1e-7 * value.left.norm());
    if (value.forms.cols() != value.multiplicity) continue;
    EXPECT_LT((value.left * value.forms -
               Eigen::MatrixXcd::Identity(value.multiplicity, value.multiplicity))
                  .norm(),
              1e-8);
  }
  EXPECT_EQ(total, matrix.rows());
}

TEST(Spectrum, LargeMatricesGiveTheirLeadingEigenvalues) {
  // A diagonal hidden by a rotation, above the size for dense work.
  const Eigen::Index n = kDenseRows + 1;
  Eigen::VectorXd diagonal(n);
  for (Eigen::Index k = 0; k < n; ++k) diagonal[k] = std::pow(0.9, static_cast<double>(k));
  const Eigen::VectorXd axis = Eigen::VectorXd::LinSpaced(n, -1, 2).normalized();
  const auto reflect = [&](const Eigen::MatrixXd& m) {
    return Eigen::MatrixXd(m - 2 * axis * (axis.transpose() * m));
  };
  const Eigen::MatrixXd matrix = reflect(reflect(diagonal.asDiagonal()).transpose());
  const auto values = spectrum(matrix);
  ASSERT_GE(values.size(), 10u);
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(values[k].value.real(), diagonal[k], 1e-9);
}

/// The fine 1-ring is what the matrix makes of the coarse one, in the whole mesh.
template <int K>
void expectClosed(const Refiner& refiner, int level, Index vertex, BoundaryMode mode) {
  LocalSubdivisionOptions options;
  options.settle = false;
  options.mode = mode;
  options.boundaryRows = refiner.boundaryRows();
  const LocalSubdivision local(refiner, level, vertex, options);
  const Complex &c = refiner.complex(level), &f = refiner.complex(level + 1), &star = local.star();
  Cochain<K> form(c);
  const auto random = testing::randomValues(form.size(), 7);
  std::copy(random.begin(), random.end(), form.values().begin());
  const Cochain<K> fine = refiner.step(level, form, mode);
  // Values on the star's simplices in their orientation, coarse and fine, cell by cell.
  Eigen::VectorXd before(star.count(K)), after(star.count(K));
  std::vector<CellAtVertex> cells, ownCells;
  c.visitVertexStar(vertex, [&](const CellAtVertex& at) { cells.push_back(at); });
  const auto byCell = [](const CellAtVertex& a, const CellAtVertex& b) { return a.cell < b.cell; };
  std::sort(cells.begin(), cells.end(), byCell);
  star.visitVertexStar(local.centre(), [&](const CellAtVertex& at) { ownCells.push_back(at); });
  std::sort(ownCells.begin(), ownCells.end(), byCell);
  ASSERT_EQ(cells.size(), ownCells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Index cell = cells[k].cell, own = ownCells[k].cell;
    const Index child = c.children().cornerChild(cell, cells[k].place);
    const auto put = [&](auto ownRef, auto ref, auto fineRef) {
      before[ownRef.index()] = ownRef.sign() * form.at(ref);
      after[ownRef.index()] = ownRef.sign() * fine.at(fineRef);
    };
    if constexpr (K == 2) {
      for (int i = 0; i < c.cellFacetCount(cell); ++i) {
        put(star.cellFacet(own, i), c.cellFacet(cell, i), f.cellFacet(child, i));
      }
    } else {
      for (int i = 0; i < c.cellVertexCount(cell); ++i) {
        if constexpr (K == 0) {
          before[star.cellVertex(own, i)] = form[c.cellVertex(cell, i)];
          after[star.cellVertex(own, i)] = fine[f.cellVertex(child, i)];
        } else {
          for (int j = 0; j < c.cellVertexCount(cell); ++j) {
            if (i == j || (!c.isTet(cell) && Octahedron::opposite[i] == j)) continue;
            put(star.cellEdge(own, i, j), c.cellEdge(cell, i, j), f.cellEdge(child, i, j));
          }
        }
      }
    }
  }
  const Eigen::MatrixXd matrix = local.matrix<K>();
  // The patch test's rows go with areas, which coordinates of size 1 round by a share of 4^level.
  const double size = (matrix.cwiseAbs() * before.cwiseAbs()).maxCoeff();
  EXPECT_LT((matrix * before - after).cwiseAbs().maxCoeff(), 3e-13 * std::pow(4, level) * size)
      << "vertex " << vertex << " degree " << K;
}

TEST(LocalSubdivision, OneRingNeedsNothingFromOutside) {
  std::set<VertexType> seen;
  for (const auto& mesh : testing::allKinds()) {
    SCOPED_TRACE(mesh.name);
    // As many levels as stay small.
    constexpr std::size_t kMostCells = 40000;
    std::size_t cells = 8 * (mesh.input.tets.size() + mesh.input.octs.size());
    int levels = 1;
    for (; levels < 2 || (levels < 4 && 8 * cells < kMostCells); ++levels) cells *= 8;
    for (const auto rows : {BoundaryRows::Smooth, BoundaryRows::Loop}) {
      const Refiner refiner = refined(mesh.input, levels, kDefaultZeta, rows);
      for (int level = 1; level < levels; ++level) {
        // A vertex of every type there is, made before this level: where irregular vertices or
        // walls lie beside each other, stars share children. Smooth walls leave some stars out.
        const auto last = rows == BoundaryRows::Loop ? VertexType::B3 : VertexType::X3;
        for (int type = 0; type <= static_cast<int>(last); ++type) {
          const Index v = firstOfType(refiner.complex(level - 1), static_cast<VertexType>(type));
          if (v == kNone) continue;
          seen.insert(static_cast<VertexType>(type));
          for (const auto mode : {BoundaryMode::Walls, BoundaryMode::Open}) {
            expectClosed<0>(refiner, level, v, mode);
            expectClosed<1>(refiner, level, v, mode);
            expectClosed<2>(refiner, level, v, mode);
          }
        }
      }
    }
  }
  EXPECT_EQ(seen.size(), 7u) << "types of vertices";
}

/// The star at the middle of an edge of n tetrahedra, as symmetric as it can be.
LocalSubdivision middleOfEdge(int n, bool patchTest = true) {
  ControlMeshInput input = testing::tetrahedraAroundEdge(n);
  input.vertices[1] = Vec3(0, 0, 1);
  for (int k = 0; k < n; ++k) input.vertices[2 + k][2] = 0;
  const Refiner refiner = refined(input, 1);
  LocalSubdivisionOptions options;
  options.patchTest = patchTest;
  return LocalSubdivision(refiner, 1, firstOfType(refiner.complex(1), VertexType::X2), options);
}

/// The star at the middle of a smooth wall edge of k tetrahedra.
LocalSubdivision middleOfWallEdge(int k, BoundaryRows rows) {
  ControlMeshInput input;
  input.vertices = {{0, 0, -1}, {0, 0, 1}};
  for (int j = 0; j <= k; ++j) {
    input.vertices.emplace_back(std::cos(kPi * j / k), std::sin(kPi * j / k), 0);
  }
  for (int j = 0; j < k; ++j) input.tets.push_back({0, 1, 2 + j, 3 + j});
  input.creases = std::vector<std::array<Index, 2>>();
  const Refiner refiner = refined(input, 1, kDefaultZeta, rows);
  const Complex& control = refiner.complex(0);
  Index edge = 0;
  while (control.edges[edge] != std::array<Index, 2>{0, 1}) ++edge;
  LocalSubdivisionOptions options;
  options.boundaryRows = rows;
  return LocalSubdivision(refiner, 1, control.children().midpoint(edge), options);
}

/// core/SCHEME.md section 8b: what the rule of walls reaches, and what section 8 alone does.
TEST(WallEdge, FluxesStayBoundedBesideIt) {
  constexpr double kSmooth[] = {.614, .659, .800, .869, .908, .931, .947};
  constexpr double kLoop[] = {.630, .709, .890};
  for (int k = 2; k <= 8; ++k) {
    const LocalSubdivision smooth = middleOfWallEdge(k, BoundaryRows::Smooth);
    EXPECT_NEAR(continuity<2>(smooth).growth, kSmooth[k - 2], 6e-4) << k;
    if (k > 4) continue;
    const LocalSubdivision loop = middleOfWallEdge(k, BoundaryRows::Loop);
    EXPECT_NEAR(continuity<2>(loop).growth, kLoop[k - 2], 6e-4) << k;
  }
}

class ExtraordinaryEdge : public ::testing::TestWithParam<int> {};

TEST_P(ExtraordinaryEdge, ReproducesConstants) {
  const LocalSubdivision local = middleOfEdge(GetParam());
  EXPECT_EQ(local.type(), VertexType::X2);
  EXPECT_LT(continuity<1>(local).constantsError, 1e-12);
  EXPECT_LT(continuity<2>(local).constantsError, 1e-12);
}

// core/SCHEME.md section 6b: what the rules reach.
constexpr double kCirculationGrowth[] = {.5748, .5748, .5748, .6000, .6000,
                                         .6000, .6082, .6189, .6270, .6332};
constexpr double kFluxGrowth[] = {.5000, .5000, .5288, .6246, .6427,
                                  .6930, .7326, .7747, .7933, .8070};

TEST_P(ExtraordinaryEdge, FieldsAreContinuousOnIt) {
  const int n = GetParam();
  const LocalSubdivision local = middleOfEdge(n);
  EXPECT_NEAR(continuity<1>(local, true).growth, kCirculationGrowth[n - 3], 1e-3);
  // Linear fields change by 1/2; where all others die out faster, the section says so.
  EXPECT_NEAR(std::max(continuity<2>(local, true).growth, 0.5), kFluxGrowth[n - 3], 1e-3);
  EXPECT_LT(continuity<1>(local).growth, 0.7);
  EXPECT_LT(continuity<2>(local).growth, 0.85);
}

TEST_P(ExtraordinaryEdge, NeedsThePatchTestForConstantFluxes) {
  const LocalSubdivision local = middleOfEdge(GetParam(), false);
  EXPECT_GT(continuity<2>(local).constantsError, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Valence3To12, ExtraordinaryEdge, ::testing::Range(3, 13));

TEST(Continuity, FollowsZetaAsTheThesisSays) {
  // Thesis 4.3, Figs 4.14 to 4.18: smooth for zeta in [-5, -7), where |p| <= 1/8 and fields have
  // bounded derivatives; rougher outside; without a limit where |p| reaches a constant's own
  // eigenvalue, 1/4 for fluxes and 1/2 for circulations.
  for (const double zeta : {-5.0, -5.5, -6.0, -6.5, -6.99}) {
    EXPECT_LT(continuity<1>(regularVertex(zeta)).growth, 0.5 + 1e-6) << zeta;
    EXPECT_LT(continuity<2>(regularVertex(zeta)).growth, 0.5 + 1e-6) << zeta;
  }
  for (const double zeta : {-4.5, -7.5}) {
    const double growth = continuity<2>(regularVertex(zeta)).growth;
    EXPECT_GT(growth, 0.7) << zeta;
    EXPECT_LT(growth, 1) << zeta;
  }
  for (const double zeta : {-3.5, -8.5}) {
    EXPECT_GT(continuity<2>(regularVertex(zeta)).growth, 1.2) << zeta;
    EXPECT_LT(continuity<1>(regularVertex(zeta)).growth, 1) << zeta;
  }
  for (const double zeta : {-1.0, -11.0}) {
    EXPECT_GT(continuity<1>(regularVertex(zeta)).growth, 1.2) << zeta;
  }
}

TEST(LocalSubdivision, RefusesWhatIsNotThere) {
  const Refiner refiner = refined(testing::regularOneRing(), 0);
  EXPECT_THROW(LocalSubdivision(refiner, 0, 19), InputError);
  EXPECT_THROW(LocalSubdivision(refiner, 0, -1), InputError);
  EXPECT_THROW(LocalSubdivision(refiner, 1, 0), InputError);
}

}  // namespace
}  // namespace octet
