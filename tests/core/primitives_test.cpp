// SPDX-License-Identifier: Apache-2.0
// Primitive flows as cochains: what quadrature of the velocity gives where it converges, closed to
// rounding where there is no divergence, and right where a singular line or source cuts a simplex.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/primitives/integrate.h>
#include <octet/core/primitives/segment_integrals.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

/// Smooth on the meshes' scale, so that quadrature of order 24 is exact to rounding.
std::vector<Primitive> smoothPrimitives() {
  return {UniformFlow{Vec3(0.3, -1.2, 0.7)},
          RigidRotation{Vec3(0.2, 0.1, -0.4), Vec3(0.5, 0.3, -1.1)},
          VortexLine{Vec3(0.1, -0.3, 0.2), Vec3(1, 2, -0.5), 1.7, 3.0},
          VortexRing{Vec3(0.3, 0.2, 0.1), Vec3(0.4, -1, 2), 1.5, -2.3, 3.0},
          PointSource{Vec3(0.2, -0.1, 0.3), 1.9, 3.0},
          CurlNoise{1.3, 9.0, 5.0, 5.0 / 3, 7, 12}};
}

Vec3 velocity(const Primitive& primitive, const Vec3& p) {
  if (const auto* noise = std::get_if<CurlNoise>(&primitive)) {
    return velocityAt(makeWaves(*noise), p);
  }
  return std::visit(
      [&](const auto& one) -> Vec3 {
        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, CurlNoise>) {
          return Vec3::Zero();
        } else {
          return velocityAt(one, p);
        }
      },
      primitive);
}

TEST(Primitives, AgreeWithQuadratureOfTheVelocity) {
  const std::vector<testing::NamedMesh> meshes = {
      {"box", testing::creasedBox(2, 0.1, 1)},
      {"octahedra", testing::withOctahedra(testing::randomBall(40, 5))},
      {"one-ring", testing::regularOneRing()}};
  for (const auto& named : meshes) {
    const ControlMesh mesh = ControlMesh::build(named.input);
    const Complex& c = *mesh.complex();
    const DeRham rham(c, mesh.positions(), 24);
    for (const Primitive& primitive : smoothPrimitives()) {
      const auto v = [&](const Vec3& p) { return velocity(primitive, p); };
      const Cochain<1> edges = rham.edges(v), w1 = integrate<1>(primitive, c, mesh.positions());
      const Cochain<2> facets = rham.facets(v), w2 = integrate<2>(primitive, c, mesh.positions());
      const double scale1 = maxNorm(edges.values()), scale2 = maxNorm(facets.values());
      for (Index e = 0; e < c.edgeCount(); ++e) {
        ASSERT_NEAR(w1[e], edges[e], 2e-12 * scale1) << named.name << ", " << nameOf(primitive);
      }
      for (Index f = 0; f < c.facetCount(); ++f) {
        ASSERT_NEAR(w2[f], facets[f], 2e-12 * scale2) << named.name << ", " << nameOf(primitive);
      }
    }
  }
}

TEST(Primitives, WithoutDivergenceAreClosedToRounding) {
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(3, 0.1, 3));
  const Complex& c = *mesh.complex();
  std::vector<Primitive> primitives = smoothPrimitives();
  primitives.push_back(VortexLine{Vec3(1.5, 1.5, 1.4), Vec3(0.1, 0.2, 1), 2.0, 0.0});
  primitives.push_back(VortexRing{Vec3(1.5, 1.4, 1.6), Vec3(0.1, 0.2, 1), 0.8, 2.0, 0.0});
  primitives.push_back(VortexRing{Vec3(1.5, 1.4, 1.6), Vec3(0.1, 0.2, 1), 0.8, 2.0, 0.02});
  for (const Primitive& primitive : primitives) {
    if (std::holds_alternative<PointSource>(primitive)) continue;
    const Cochain<2> w = integrate<2>(primitive, c, mesh.positions());
    EXPECT_GT(maxNorm(w.values()), 1e-3);
    EXPECT_LE(maxNorm(d(c, w).values()), 1e-14 * maxNorm(w.values()) + 1e-15) << nameOf(primitive);
  }
}

/// Integral of f over a segment by many Gauss intervals that shrink towards a point on it.
template <typename Function>
double graded(const Function& f, double from, double to, double singular) {
  const GaussRule rule(12);
  const auto on = [&](double a, double b) {
    double sum = 0;
    for (std::size_t k = 0; k < rule.points.size(); ++k) {
      sum += rule.weights[k] * f(a + rule.points[k] * (b - a));
    }
    return sum * (b - a);
  };
  double sum = 0;
  for (const double end : {from, to}) {
    double far = end;
    for (int k = 0; k < 50; ++k) {
      const double near = singular + (far - singular) / 2;
      sum += end == from ? on(far, near) : on(near, far);
      far = near;
    }
  }
  return sum;
}

TEST(VortexLine, PotentialIsExactThroughTheSingularLine) {
  const VortexLine line{Vec3(0.1, 0.2, 0.3), Vec3(0, 0, 2), 1.5, 0.0};
  // Crosses the line at parameter 0.3; then passes it at a hair's breadth; then far away.
  const Vec3 e(0.7, -0.4, 1.1);
  for (const double miss : {0.0, 1e-9, 1e-3, 0.5, 40.0}) {
    const Vec3 a = line.point - 0.3 * e + miss * Vec3(0.4, 0.7, 0).normalized(), b = a + e;
    const auto potential = [&](double s) {
      const Vec3 p = a + s * e - line.point;
      return -line.circulation / (4 * M_PI) * std::log(p.head<2>().squaredNorm()) * e[2];
    };
    EXPECT_NEAR(potentialAlong(line, a, b), graded(potential, 0, 1, 0.3), 1e-13) << miss;
  }
}

TEST(VortexLine, GivesThePiercedFacetsItsCirculation) {
  const VortexLine line{Vec3(1.47, 1.53, 0), Vec3(0.02, 0.03, 1), 2.5, 0.0};
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(3, 0.1, 5));
  const Complex& c = *mesh.complex();
  const Cochain<2> vorticity = d(c, integrate<1>(line, c, mesh.positions()));
  int pierced = 0;
  for (Index f = 0; f < c.facetCount(); ++f) {
    const auto [i, j, k] = c.facetVertices(f);
    const Vec3 &x = mesh.positions()[i], &y = mesh.positions()[j], &z = mesh.positions()[k];
    // Signs of the volumes that the line spans with the three edges.
    const auto side = [&](const Vec3& p, const Vec3& q) {
      return line.direction.dot((p - line.point).cross(q - line.point));
    };
    const double s = side(x, y), t = side(y, z), u = side(z, x);
    const double expected = s > 0 && t > 0 && u > 0   ? line.circulation
                            : s < 0 && t < 0 && u < 0 ? -line.circulation
                                                      : 0;
    pierced += expected != 0;
    EXPECT_NEAR(vorticity[f], expected, 1e-13);
  }
  EXPECT_GE(pierced, 6);
}

TEST(VortexLine, WithoutCoreAlongAnEdgeIsRefused) {
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(2, 0, 1));
  EXPECT_THROW(integrate<2>(VortexLine{Vec3::Zero(), Vec3::UnitX(), 1, 0}, *mesh.complex(),
                            mesh.positions()),
               InputError);
}

TEST(VortexRing, HasTheKnownVelocityOnItsAxis) {
  const VortexRing ring{Vec3(1, 2, 3), Vec3(0, 0, 5), 0.7, 2.0, 0.0};
  for (const double z : {0.0, 0.3, -2.0}) {
    const Vec3 v = velocityAt(ring, ring.centre + Vec3(0, 0, z));
    const double size = std::pow(0.49 + z * z, 1.5);
    EXPECT_NEAR((v - Vec3(0, 0, 2.0 * 0.49 / (2 * size))).norm(), 0, 1e-14);
  }
}

TEST(VortexRing, PotentialAgreesWithLegendresIntegrals) {
  const VortexRing ring{Vec3::Zero(), Vec3::UnitZ(), 1.0, 1.0, 0.1};
  for (const double rho : {0.2, 0.9, 1.0, 1.7}) {
    const double z = 0.15, sum = (1 + rho) * (1 + rho) + z * z + 0.01;
    const double k = std::sqrt(4 * rho / sum);
    const double expected = std::sqrt(1 / rho) / (2 * M_PI) *
                            ((2 / k - k) * std::comp_ellint_1(k) - 2 / k * std::comp_ellint_2(k));
    // A short segment across the radius, over its length.
    const Vec3 p(rho, 0, z), step(0, 1e-4, 0);
    EXPECT_NEAR(potentialAlong(ring, p - step, p + step) / 2e-4, expected, 1e-7) << rho;
  }
}

/// The flux through a surface that the ring pierces once is not finite; through one that it does
/// not, it is what quadrature gives.
TEST(VortexRing, PotentialIsIntegrableThroughTheSingularRing) {
  const VortexRing ring{Vec3::Zero(), Vec3::UnitZ(), 1.0, 1.0, 0.0};
  // A segment that meets the ring at its middle, at a slant.
  const Vec3 at(std::cos(0.7), std::sin(0.7), 0), e(0.3, 0.8, 0.5);
  const Vec3 a = at - 0.5 * e, b = at + 0.5 * e;
  const double whole = potentialAlong(ring, a, b);
  EXPECT_TRUE(std::isfinite(whole));
  // Additive over parts: the singularity is met inside, or at the end of a part.
  EXPECT_NEAR(whole, potentialAlong(ring, a, at) + potentialAlong(ring, at, b), 1e-11);
  EXPECT_NEAR(whole, potentialAlong(ring, a, at + 0.1 * e) + potentialAlong(ring, at + 0.1 * e, b),
              1e-11);
}

TEST(Source, PutsItsStrengthIntoTheCellThatHoldsIt) {
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(3, 0.1, 7));
  const Complex& c = *mesh.complex();
  const auto& x = mesh.positions();
  const auto divergence = [&](const Vec3& p, double core) {
    return d(c, integrate<2>(PointSource{p, 2.0, core}, c, x));
  };
  const auto total = [](const Cochain<3>& w) {
    double sum = 0;
    for (const double value : w.values()) sum += value;
    return sum;
  };
  // Cells count as positively oriented, whichever way they are stored.
  const auto& tet = c.tets[40];
  const Vec3 inside = 0.3 * x[tet[0]] + 0.2 * x[tet[1]] + 0.4 * x[tet[2]] + 0.1 * x[tet[3]];
  const Cochain<3> w = divergence(inside, 0);
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    EXPECT_NEAR(w[cell], cell == 40 ? 2.0 : 0.0, 1e-13);
  }
  // On a vertex, an edge and a facet inside the box it is shared, and none is lost.
  for (Index v = 0; v < c.vertexCount(); ++v) {
    if (c.vertexOnBoundary(v)) continue;
    const Cochain<3> shared = divergence(x[v], 0);
    EXPECT_NEAR(total(shared), 2.0, 1e-12);
    c.visitVertexStar(v, [&](const CellAtVertex& at) {
      EXPECT_GT(shared[at.cell], 1e-3);
      EXPECT_LT(shared[at.cell], 1.0);
    });
  }
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (c.edgeOnBoundary(e)) continue;
    const Cochain<3> shared = divergence(0.37 * x[c.edges[e][0]] + 0.63 * x[c.edges[e][1]], 0);
    EXPECT_NEAR(total(shared), 2.0, 1e-12);
    for (Index cell = 0; cell < c.cellCount(); ++cell) {
      EXPECT_GT(shared[cell], -1e-12);
      EXPECT_LT(shared[cell], 1.9);
    }
  }
  // With a core it spreads, most of it in the box.
  EXPECT_GT(total(divergence(inside, 0.3)), 1.0);
  EXPECT_LT(total(divergence(inside, 0.3)), 2.0);
}

TEST(CurlNoise, IsTheSameForASeedAndHasItsSpeedAndSpectrum) {
  CurlNoise noise{2.0, 4.0, 0.25, 5.0 / 3, 42, 4000};
  const NoiseWaves waves = makeWaves(noise);
  ASSERT_EQ(waves.size(), 4000u);
  double meanSquare = 0, octave[4] = {};
  for (const NoiseWave& w : waves) {
    EXPECT_NEAR(w.wave.dot(w.amplitude), 0, 1e-12 * w.wave.norm() * w.amplitude.norm());
    const double energy = w.wave.cross(w.amplitude).squaredNorm() / 2;
    const double wavelength = 2 * M_PI / w.wave.norm();
    EXPECT_LE(wavelength, 4.0 * (1 + 1e-12));
    EXPECT_GE(wavelength, 0.25 * (1 - 1e-12));
    meanSquare += energy;
    octave[std::min(3, static_cast<int>(std::log2(4.0 / wavelength)))] += energy;
  }
  EXPECT_NEAR(meanSquare, 4.0, 1e-12);
  // The energy in an octave of wave numbers goes like k^(1 - 5/3).
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(octave[k + 1] / octave[k], std::pow(2, -2.0 / 3), 0.01);
  }
  // mt19937 is the same everywhere, and so are these.
  const NoiseWaves again = makeWaves(noise);
  for (std::size_t k = 0; k < waves.size(); ++k) EXPECT_EQ(waves[k].phase, again[k].phase);
  noise.seed = 43;
  EXPECT_NE(makeWaves(noise)[0].phase, waves[0].phase);
  // Mean square over many points.
  double sum = 0;
  const auto random = testing::randomValues(3 * 2000, 1);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = 100 * Vec3(random[3 * k], random[3 * k + 1], random[3 * k + 2]);
    sum += velocityAt(waves, p).squaredNorm();
  }
  EXPECT_NEAR(sum / 2000, 4.0, 0.4);
}

TEST(Primitives, RefuseBadNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vec3 o = Vec3::Zero(), z = Vec3::UnitZ();
  const std::vector<Primitive> bad = {UniformFlow{Vec3(nan, 0, 0)},
                                      RigidRotation{o, Vec3(HUGE_VAL, 0, 0)},
                                      VortexLine{o, o, 1, 0},
                                      VortexLine{o, z, nan, 0},
                                      VortexLine{o, z, 1, -1},
                                      VortexRing{o, z, 0, 1, 0.1},
                                      VortexRing{o, z, -1, 1, 0.1},
                                      VortexRing{o, o, 1, 1, 0.1},
                                      PointSource{o, 1, nan},
                                      CurlNoise{1, 1, 2, 5.0 / 3, 0, 8},
                                      CurlNoise{1, 1, 0, 5.0 / 3, 0, 8},
                                      CurlNoise{1, 1, 0.5, 5.0 / 3, 0, 0}};
  for (const Primitive& primitive : bad) EXPECT_THROW(checkPrimitive(primitive), InputError);
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(2, 0, 1));
  EXPECT_THROW(
      integrate<1>(PointSource{mesh.positions()[3], 1, 0}, *mesh.complex(), mesh.positions()),
      InputError);
  EXPECT_THROW(integrate<1>(VortexRing{o, z, 1, 1, 0}, *mesh.complex(), mesh.positions()),
               InputError);
}

}  // namespace
}  // namespace octet
