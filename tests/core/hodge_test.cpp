// SPDX-License-Identifier: Apache-2.0
// Mass matrices and projections: energies of fields, and the closed form nearest to a given one.
#include <Eigen/SparseCholesky>

#include <gtest/gtest.h>

#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/hodge/coboundary_matrix.h>
#include <octet/core/hodge/mass_matrix.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"
#include "tests/support/test_name.h"

namespace octet {
namespace {

using testing::NamedMesh;
using testing::randomForm;
using testing::testName;

template <int K>
Eigen::Map<const Eigen::VectorXd> vector(const Cochain<K>& form) {
  return {form.data(), form.size()};
}

template <int K>
double product(const Eigen::SparseMatrix<double>& mass, const Cochain<K>& a, const Cochain<K>& b) {
  return vector(a).dot(mass * vector(b));
}

template <int K>
Cochain<K> minus(const Cochain<K>& a, const Cochain<K>& b) {
  Cochain<K> result = a;
  for (Index k = 0; k < a.size(); ++k) result[k] -= b[k];
  return result;
}

double volume(const Complex& c, const Array<Vec3>& x) {
  double sum = 0;
  for (Index cell = 0; cell < c.cellCount(); ++cell) sum += std::abs(cellVolume6(c, x, cell)) / 6;
  return sum;
}

class HodgeOn : public ::testing::TestWithParam<NamedMesh> {
 protected:
  HodgeOn() : mesh(ControlMesh::build(GetParam().input)), c(*mesh.complex()), x(mesh.positions()) {}

  template <int K>
  void expectPositiveDefinite() const {
    const auto mass = massMatrix<K>(c, x);
    EXPECT_EQ(Eigen::SparseMatrix<double>(mass.transpose()).isApprox(mass, 1e-14), true);
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors(mass);
    EXPECT_EQ(factors.info(), Eigen::Success) << "degree " << K;
  }

  ControlMesh mesh;
  const Complex& c;
  const Array<Vec3>& x;
};

// ---- Mass matrices ------------------------------------------------------------------------------

TEST_P(HodgeOn, MassesArePositiveDefinite) {
  expectPositiveDefinite<0>();
  expectPositiveDefinite<1>();
  expectPositiveDefinite<2>();
  expectPositiveDefinite<3>();
}

TEST_P(HodgeOn, ConstantsHaveTheirExactEnergy) {
  const DeRham rham(c, x, 1);
  const Vec3 a(0.3, -1.2, 0.7), b(2, 0.4, -0.1);
  const auto of = [](const Vec3& v) { return [v](const Vec3&) { return v; }; };
  const double v = volume(c, x), exact = a.dot(b) * v, tolerance = 1e-12 * a.norm() * b.norm() * v;
  EXPECT_NEAR(product(massMatrix<1>(c, x), rham.edges(of(a)), rham.edges(of(b))), exact, tolerance);
  EXPECT_NEAR(product(massMatrix<2>(c, x), rham.facets(of(a)), rham.facets(of(b))), exact,
              tolerance);
  const auto one = [](const Vec3&) { return 1.5; };
  EXPECT_NEAR(product(massMatrix<0>(c, x), rham.vertices(one), rham.vertices(one)), 2.25 * v,
              1e-12 * v);
  EXPECT_NEAR(product(massMatrix<3>(c, x), rham.cells(one), rham.cells(one)), 2.25 * v, 1e-12 * v);
}

INSTANTIATE_TEST_SUITE_P(Meshes, HodgeOn, ::testing::ValuesIn(testing::allKinds()), testName);

/// Meshes whose octahedra, if any, are affine images of the regular one.
std::vector<NamedMesh> affineMeshes() {
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 9; };
  ControlMeshInput sheared = testing::latticeBlock(ball, 3);
  Eigen::Matrix3d shear;
  shear << 1, 0.3, 0.1, -0.2, 0.7, 0.4, 0.05, -0.1, 1.6;
  for (Vec3& p : sheared.vertices) p = shear * p;
  return {{"tetrahedra", testing::randomBall(50, 4)},
          {"sheared lattice", sheared},
          {"octahedron", testing::singleOctahedron()}};
}

class HodgeOnAffine : public HodgeOn {
 protected:
  template <int K>
  void expectSameEnergy(const Refiner& refiner) const {
    const auto u = randomForm<K>(c, 5), v = randomForm<K>(c, 6);
    const double coarse = product(massMatrix<K>(c, x), u, v);
    const double size = product(massMatrix<K>(c, x), u, u);
    const double fine =
        product(massMatrix<K>(refiner.finest(), refiner.positions(2)),
                refiner.refine(u, BoundaryMode::Open), refiner.refine(v, BoundaryMode::Open));
    EXPECT_NEAR(fine, coarse, 1e-12 * size) << "degree " << K;
  }
};

/// The Whitney form of the linearly refined cochain is the same field: only the exact integral of
/// every cell shape keeps its energy.
TEST_P(HodgeOnAffine, LinearRefinementKeepsEnergy) {
  RefinerOptions options;
  options.levels = 2;
  options.smooth = false;
  const Refiner refiner(mesh, options);
  expectSameEnergy<0>(refiner);
  expectSameEnergy<1>(refiner);
  expectSameEnergy<2>(refiner);
  expectSameEnergy<3>(refiner);
}

INSTANTIATE_TEST_SUITE_P(Meshes, HodgeOnAffine, ::testing::ValuesIn(affineMeshes()), testName);

// ---- Projections --------------------------------------------------------------------------------

template <int K>
void expectClosed(const Complex& c, const Cochain<K>& form) {
  EXPECT_LE(maxNorm(d(c, form).values()), 1e-13 * maxNorm(form.values())) << "degree " << K;
}

template <int K>
void expectNearestClosed(const Complex& c, const Array<Vec3>& x) {
  const auto mass = massMatrix<K>(c, x);
  const auto form = randomForm<K>(c, 7);
  const auto closed = nearestClosed<K>(c, x, form);
  expectClosed(c, closed);
  // Nearest: what was taken away is orthogonal to all closed forms, of which derivatives are some.
  const auto removed = minus(form, closed);
  for (std::uint32_t seed = 20; seed < 24; ++seed) {
    const auto other = d(c, randomForm<K - 1>(c, seed));
    const double scale = std::sqrt(product(mass, removed, removed) * product(mass, other, other));
    EXPECT_LT(std::abs(product(mass, removed, other)), 1e-11 * scale) << "degree " << K;
  }
  const double scale = product(mass, removed, removed);
  EXPECT_LT(std::abs(product(mass, removed, closed)), 1e-11 * scale + 1e-13) << "degree " << K;
  // A closed form is its own projection.
  const auto again = minus(closed, nearestClosed<K>(c, x, closed));
  EXPECT_LT(maxNorm(again.values()), 1e-12 * maxNorm(closed.values())) << "degree " << K;
}

TEST_P(HodgeOn, ProjectionIsTheNearestClosedForm) {
  expectNearestClosed<1>(c, x);
  expectNearestClosed<2>(c, x);
}

TEST_P(HodgeOn, ProjectionClosesWalls) {
  const auto form = randomForm<2>(c, 8);
  const auto closed = nearestClosed(c, x, form, BoundaryRule::Zero);
  expectClosed(c, closed);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) {
      ASSERT_EQ(closed[f], 0);
    }
  }
  // Nearest among forms without flux through walls: curls of potentials that vanish there.
  auto potential = randomForm<1>(c, 9);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (c.edgeOnBoundary(e)) potential[e] = 0;
  }
  const auto mass = massMatrix<2>(c, x);
  const auto other = d(c, potential), removed = minus(form, closed);
  const double scale = std::sqrt(product(mass, removed, removed) * product(mass, other, other));
  EXPECT_LE(std::abs(product(mass, removed, other)), 1e-11 * scale);
}

TEST_P(HodgeOn, ProjectionKeepsTheBoundary) {
  // A closed form disturbed inside: a closed form with its boundary exists.
  auto form = d(c, randomForm<1>(c, 10));
  const auto noise = randomForm<2>(c, 11);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (!c.facetOnBoundary(f)) form[f] += noise[f];
  }
  const auto closed = nearestClosed(c, x, form, BoundaryRule::Keep);
  expectClosed(c, closed);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) {
      ASSERT_EQ(closed[f], form[f]);
    }
  }
}

/// A block with a hole in its middle: nothing passes the hole's walls, but the outer boundary.
TEST(ClosedProjection, ClosesTheWallsOfCavitiesAlone) {
  const auto inside = [](int i, int j, int k) {
    const int most = std::max({std::abs(i), std::abs(j), std::abs(k)});
    return most <= 4 && most >= 2;
  };
  const ControlMesh mesh = ControlMesh::build(testing::latticeBlock(inside, 5));
  const Complex& c = *mesh.complex();
  const auto& x = mesh.positions();
  const auto flux = nearestClosed(c, x, randomForm<2>(c, 12), BoundaryRule::ZeroInside);
  expectClosed(c, flux);
  const auto along = nearestClosed(c, x, randomForm<1>(c, 13), BoundaryRule::ZeroInside);
  expectClosed(c, along);
  int outer = 0, inner = 0;
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (!c.facetOnBoundary(f)) continue;
    double reach = 0;
    for (const Index v : c.facetVertices(f)) reach = std::max(reach, x[v].norm());
    const bool onHole = reach < 3.6;  // its farthest corner is at 2 sqrt(3), outer facets from 4 on
    ASSERT_EQ(flux[f] == 0, onHole);
    for (const EdgeRef& e : c.facetEdges[f]) ASSERT_EQ(along[e.index()] == 0, onHole);
    ++(onHole ? inner : outer);
  }
  EXPECT_GT(inner, 0);
  EXPECT_GT(outer, inner);
}

TEST(ClosedProjection, RefusesANetFluxThroughAKeptBoundary) {
  const ControlMesh mesh = ControlMesh::build(testing::randomBall(50, 4));
  const Complex& c = *mesh.complex();
  Cochain<2> form(c);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) form[f] = c.facetCells[f][0].exists() ? 1 : -1;
  }
  EXPECT_THROW(nearestClosed(c, mesh.positions(), form, BoundaryRule::Keep), InputError);
  EXPECT_NO_THROW(nearestClosed(c, mesh.positions(), form, BoundaryRule::Free));
}

TEST(CoboundaryMatrix, IsTheExteriorDerivative) {
  const ControlMesh mesh = ControlMesh::build(testing::withOctahedra(testing::randomBall(60, 5)));
  const Complex& c = *mesh.complex();
  const auto f = randomForm<0>(c, 1);
  const auto w = randomForm<1>(c, 2);
  const auto u = randomForm<2>(c, 3);
  EXPECT_LT((coboundaryMatrix<0>(c) * vector(f) - vector(d(c, f))).norm(), 1e-13);
  EXPECT_LT((coboundaryMatrix<1>(c) * vector(w) - vector(d(c, w))).norm(), 1e-13);
  EXPECT_LT((coboundaryMatrix<2>(c) * vector(u) - vector(d(c, u))).norm(), 1e-13);
}

}  // namespace
}  // namespace octet
