// SPDX-License-Identifier: Apache-2.0
// What the thesis' boundary methods claim (its chapter 5): constants, commutation with d, the
// lattice, and what they are known to spoil.
#include <gtest/gtest.h>

#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/thesis/thesis_subdivision.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"

namespace octet {
namespace {

using testing::randomForm;

/// To no method does the mode matter.
constexpr auto kAnyMode = BoundaryMode::Walls;

std::unique_ptr<Subdivision> refined(const ControlMesh& mesh, ThesisMethod method, int levels) {
  RefinerOptions options;
  options.levels = levels;
  return subdivideByThesis(mesh, method, options);
}
std::unique_ptr<Subdivision> refined(const ControlMeshInput& input, ThesisMethod method,
                                     int levels) {
  return refined(ControlMesh::build(input), method, levels);
}

template <int K>
double difference(const Cochain<K>& a, const Cochain<K>& b) {
  double most = 0;
  EXPECT_EQ(a.size(), b.size());
  for (Index k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

/// Coefficients of a vector field on a level as the method places it.
template <int K, typename Function>
Cochain<K> integrals(const Subdivision& refiner, int level, const Function& field) {
  const DeRham deRham(*refiner.complex(level), refiner.positions(level), 4);
  if constexpr (K == 1) return deRham.edges(field);
  if constexpr (K == 2) return deRham.facets(field);
}

template <int K, typename Function>
double misses(const Subdivision& refiner, const Function& field) {
  const auto coarse = integrals<K>(refiner, 0, field);
  return difference(refiner.refine(coarse, kAnyMode),
                    integrals<K>(refiner, refiner.levels(), field));
}

Vec3 constantField(const Vec3&) { return Vec3(0.3, -1.1, 0.7); }

/// A convex piece of the lattice, an octahedron of side 2 n.
ControlMeshInput octahedralBlock(int n) {
  return testing::latticeBlock(
      [n](int x, int y, int z) { return std::abs(x) + std::abs(y) + std::abs(z) <= 2 * n; }, 2 * n);
}

/// Meshes of every kind that are small enough to be expanded in a moment.
std::vector<testing::NamedMesh> smallMeshes() {
  constexpr std::size_t kMostCells = 200;
  std::vector<testing::NamedMesh> result;
  for (auto& mesh : testing::allKinds()) {
    if (mesh.input.tets.size() + mesh.input.octs.size() <= kMostCells) result.push_back(mesh);
  }
  return result;
}

TEST(Expansion, ReproducesConstantsOnAnyMesh) {
  for (const auto& mesh : smallMeshes()) {
    SCOPED_TRACE(mesh.name);
    const auto refiner = refined(mesh.input, ThesisMethod::Expansion, 2);
    EXPECT_LT(misses<1>(*refiner, constantField), 1e-11);
    EXPECT_LT(misses<2>(*refiner, constantField), 1e-11);
  }
}

/// d of a refined form and the refined d of it.
template <int K>
double commutes(const Subdivision& refiner, std::uint32_t seed) {
  const auto form = randomForm<K>(*refiner.complex(0), seed);
  return difference(d(*refiner.finest(), refiner.refine(form, kAnyMode)),
                    refiner.refine(d(*refiner.complex(0), form), kAnyMode));
}

TEST(Expansion, CommutesWithTheDerivativeOnAnyMesh) {
  auto meshes = smallMeshes();
  // Slivers left out of a ball are voids in it, or touch its boundary from within.
  for (const std::uint32_t seed : {7u, 8u, 9u}) {
    const auto ball = testing::randomBall(40, seed);
    meshes.push_back({"ball " + std::to_string(seed), ball});
    meshes.push_back({"mixed ball " + std::to_string(seed), testing::withOctahedra(ball)});
  }
  meshes.push_back({"octahedral block", octahedralBlock(2)});
  for (const auto& mesh : meshes) {
    SCOPED_TRACE(mesh.name);
    const auto refiner = refined(mesh.input, ThesisMethod::Expansion, 2);
    EXPECT_TRUE(refiner->commutes());
    EXPECT_LT(commutes<0>(*refiner, 1), 1e-12);
    EXPECT_LT(commutes<1>(*refiner, 2), 1e-12);
    EXPECT_LT(commutes<2>(*refiner, 3), 1e-12);
  }
}

TEST(Expansion, SaysWhereNothingCanCommute) {
  // Cells of the lattice fill the void of one octahedron: a flow out of it would have a source.
  auto input = octahedralBlock(2);
  const auto atCentre = [&](const std::array<Index, 6>& oct) {
    Vec3 sum = Vec3::Zero();
    for (const Index v : oct) sum += input.vertices[static_cast<std::size_t>(v)];
    return (sum / 6 - Vec3(1, 0, 0)).norm() < 1e-9;
  };
  const auto gap = std::find_if(input.octs.begin(), input.octs.end(), atCentre);
  ASSERT_NE(gap, input.octs.end());
  input.octs.erase(gap);
  const auto refiner = refined(input, ThesisMethod::Expansion, 1);
  EXPECT_FALSE(refiner->commutes());
  EXPECT_LT(commutes<0>(*refiner, 1), 1e-12);
  EXPECT_LT(commutes<1>(*refiner, 2), 1e-12);
  EXPECT_GT(commutes<2>(*refiner, 3), 1e-3);
  EXPECT_LT(misses<2>(*refiner, constantField), 1e-11);
}

TEST(Expansion, DoesNotShrinkALatticeBlock) {
  // Thesis 5.4: the block, with its edges and corners, is what it was.
  const auto input = octahedralBlock(1);
  const auto refiner = refined(input, ThesisMethod::Expansion, 3);
  for (Index v = 0; v < refiner->complex(3)->vertexCount(); ++v) {
    const Vec3& p = refiner->positions(3)[v];
    EXPECT_LT(p.cwiseAbs().sum(), 2 + 1e-12);
    if (v < static_cast<Index>(input.vertices.size())) {
      EXPECT_LT((p - input.vertices[v]).norm(), 1e-12);
    }
  }
}

TEST(Expansion, IsTheSchemeItselfAwayFromTheBoundary) {
  const auto input = octahedralBlock(3);
  const ControlMesh mesh = ControlMesh::build(input);
  const auto refiner = refined(mesh, ThesisMethod::Expansion, 1);
  RefinerOptions options;
  options.levels = 1;
  const Refiner plain(mesh, options);
  const auto form = randomForm<2>(*refiner->complex(0), 5);
  const auto ours = refiner->refine(form, kAnyMode), theirs = plain.refine(form, kAnyMode);
  int compared = 0;
  for (Index f = 0; f < ours.size(); ++f) {
    double reach = 0;
    for (const Index v : refiner->complex(1)->facetVertices(f)) {
      reach = std::max(reach, refiner->positions(1)[v].cwiseAbs().sum());
    }
    if (reach > 3) continue;
    ++compared;
    EXPECT_NEAR(ours[f], theirs[f], 1e-13);
  }
  EXPECT_GT(compared, 100);
}

TEST(Projection, ReproducesConstantsOnAnyMesh) {
  for (const auto& mesh : testing::allKinds()) {
    SCOPED_TRACE(mesh.name);
    const auto refiner = refined(mesh.input, ThesisMethod::Projection, 2);
    EXPECT_LT(misses<1>(*refiner, constantField), 1e-11);
    EXPECT_LT(misses<2>(*refiner, constantField), 1e-11);
  }
}

TEST(Projection, KeepsFlatWallsWhereTheyAre) {
  const auto input = octahedralBlock(2);
  const auto refiner = refined(input, ThesisMethod::Projection, 3);
  const Complex& c = *refiner->complex(3);
  for (Index v = 0; v < c.vertexCount(); ++v) {
    if (!c.vertexOnBoundary(v)) continue;
    EXPECT_NEAR(refiner->positions(3)[v].cwiseAbs().sum(), 4, 1e-12);
  }
}

TEST(Simple, LosesTheBoundaryAndShrinks) {
  const auto refiner = refined(octahedralBlock(2), ThesisMethod::Simple, 2);
  const Complex& c = *refiner->complex(2);
  const auto fine = refiner->refine(integrals<2>(*refiner, 0, constantField), kAnyMode);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) {
      EXPECT_EQ(fine[f], 0);
    }
  }
  double reach = 0;
  for (Index v = 0; v < c.vertexCount(); ++v) {
    reach = std::max(reach, refiner->positions(2)[v].cwiseAbs().sum());
  }
  EXPECT_LT(reach, 3.95);
  EXPECT_GT(misses<2>(*refiner, constantField), 1e-3);
}

TEST(ThesisSubdivision, HasTheTopologyOfRefiner) {
  const auto input = testing::withOctahedra(testing::randomBall(60, 5));
  RefinerOptions options;
  options.levels = 2;
  const Refiner plain(ControlMesh::build(input), options);
  const auto refiner = refined(input, ThesisMethod::Expansion, 2);
  EXPECT_TRUE(refiner->complex(2)->edges == plain.complex(2).edges);
  EXPECT_TRUE(refiner->complex(2)->octs == plain.complex(2).octs);
}

TEST(ThesisSubdivision, RefusesAFormOfAnotherMesh) {
  const auto refiner = refined(testing::singleTetrahedron(), ThesisMethod::Simple, 1);
  EXPECT_THROW(refiner->refine(Cochain<1>(Array<double>(5, 0.0)), kAnyMode), InputError);
}

TEST(ThesisSubdivision, FieldsReachUpToTheBoundary) {
  const auto input = octahedralBlock(2);
  for (const auto method : {ThesisMethod::Projection, ThesisMethod::Expansion}) {
    const auto refiner = refined(input, method, 2);
    const auto field = makeField(*refiner, integrals<2>(*refiner, 0, constantField), kAnyMode);
    Vec3 value;
    for (const Vec3& p : {Vec3(0.1, 0.2, 0.3), Vec3(3.9, 0.02, 0.03), Vec3(1.3, 1.3, 1.39)}) {
      ASSERT_TRUE(field.sample(p, &value));
      EXPECT_LT((value - constantField(p)).norm(), 1e-10);
    }
    EXPECT_FALSE(field.sample(Vec3(2, 2, 2), &value));
  }
}

}  // namespace
}  // namespace octet
