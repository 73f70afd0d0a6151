// SPDX-License-Identifier: Apache-2.0
// The de Rham map: exact for polynomials of the stated order, and it commutes with d (Stokes).
#include <gtest/gtest.h>

#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

TEST(DeRham, GaussRulesIntegratePolynomials) {
  for (int n = 1; n <= 12; ++n) {
    const GaussRule rule(n);
    for (int degree = 0; degree < 2 * n; ++degree) {
      double sum = 0;
      for (std::size_t k = 0; k < rule.points.size(); ++k) {
        sum += rule.weights[k] * std::pow(rule.points[k], degree);
      }
      EXPECT_NEAR(sum, 1.0 / (degree + 1), 1e-14) << n << " points, degree " << degree;
    }
  }
}

class DeRhamOn : public ::testing::TestWithParam<testing::NamedMesh> {};

TEST_P(DeRhamOn, StokesHoldsForPolynomials) {
  const ControlMesh mesh = ControlMesh::build(GetParam().input);
  const Complex& c = *mesh.complex();
  const DeRham rham(c, mesh.positions(), 4);
  const auto f = [](const Vec3& p) { return p[0] * p[0] * p[1] - 2 * p[2] * p[1] + p[0]; };
  const auto gradF = [](const Vec3& p) {
    return Vec3(2 * p[0] * p[1] + 1, p[0] * p[0] - 2 * p[2], -2 * p[1]);
  };
  const auto v = [](const Vec3& p) {
    return Vec3(p[1] * p[2], p[0] * p[0] * p[2], p[1] * p[1] * p[1]);
  };
  const auto curlV = [](const Vec3& p) {
    return Vec3(3 * p[1] * p[1] - p[0] * p[0], p[1], 2 * p[0] * p[2] - p[2]);
  };
  const auto u = [](const Vec3& p) { return Vec3(p[0] * p[0], p[1] * p[2], p[2] * p[0] * p[1]); };
  const auto divU = [](const Vec3& p) { return 2 * p[0] + p[2] + p[0] * p[1]; };
  const auto expectSame = [](const auto& a, const auto& b) {
    double scale = 1;
    for (Index k = 0; k < a.size(); ++k) scale = std::max(scale, std::abs(a[k]));
    for (Index k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-13 * scale);
  };
  expectSame(d(c, rham.vertices(f)), rham.edges(gradF));
  expectSame(d(c, rham.edges(v)), rham.facets(curlV));
  expectSame(d(c, rham.facets(u)), rham.cells(divU));
}

INSTANTIATE_TEST_SUITE_P(Meshes, DeRhamOn, ::testing::ValuesIn(testing::allKinds()),
                         [](const auto& mesh) {
                           std::string name = mesh.param.name;
                           for (char& ch : name) {
                             if (!std::isalnum(static_cast<unsigned char>(ch))) ch = '_';
                           }
                           return name;
                         });

TEST(DeRham, OrderOutOfRangeIsRefused) {
  const ControlMesh mesh = ControlMesh::build(testing::singleTetrahedron());
  EXPECT_THROW(DeRham(*mesh.complex(), mesh.positions(), -1), InputError);
  EXPECT_THROW(DeRham(*mesh.complex(), mesh.positions(), 41), InputError);
}

}  // namespace
}  // namespace octet
