// SPDX-License-Identifier: Apache-2.0
// Conservative bakes and their certificate, from control asset to file and back.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include <octet/converters/vdb/bake.h>
#include <octet/converters/vdb/certificate.h>
#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/hodge/projection.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

namespace fs = std::filesystem;

/// A folder of its own, gone with the test.
class Conservative : public ::testing::Test {
 protected:
  Conservative() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("octet_" + std::string(info->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  ~Conservative() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Bakes one form and measures the file.
  Certificate baked(const ControlAsset& asset, const std::string& form, BakeOptions options) {
    options.forms = {form};
    report_ = bake(asset, options, path("out.vdb"));
    return verifyVdb(path("out.vdb"), form).at(0).certificate;
  }
  const VdbGridInfo& grid() const { return report_.files.at(0).grids.at(0); }

  fs::path folder_;
  BakeReport report_;
};

template <int K>
Cochain<K> randomForm(const Complex& complex, std::uint32_t seed) {
  const auto values = testing::randomValues(complex.count(K), seed);
  return Cochain<K>(Array<double>(values.begin(), values.end()));
}

/// A mesh with a random closed flow "velocity" and its "potential".
ControlAsset randomAsset(const ControlMeshInput& input, bool closedWalls, std::uint32_t seed) {
  ControlAsset asset{"random", {}, ControlMesh::build(input), {}};
  const Complex& c = *asset.mesh.complex();
  auto potential = randomForm<1>(c, seed);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (closedWalls && c.edgeOnBoundary(e)) potential[e] = 0;
  }
  asset.forms = {makeForm<2>("velocity", d(c, potential)), makeForm<1>("potential", potential)};
  return asset;
}

BakeOptions staggered(double voxelSize, int levels) {
  BakeOptions options;
  options.voxelSize = voxelSize;
  options.levels = levels;
  options.sampling = Sampling::Staggered;
  return options;
}

double meanEdge(const ControlMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b] : mesh.complex()->edges) {
    sum += (mesh.positions()[a] - mesh.positions()[b]).norm();
  }
  return sum / mesh.complex()->edgeCount();
}

/// Finer than the fine cells, alike, coarser: voxels per fine edge.
constexpr double kRatios[] = {0.5, 1.0, 1.5};

TEST_F(Conservative, RandomClosedFormsHaveNoDivergence) {
  struct Case {
    const char* name;
    ControlMeshInput mesh;
    bool closedWalls;
  };
  const std::vector<Case> cases = {
      {"ball, walls", testing::randomBall(60, 21), true},
      {"ball, open", testing::randomBall(150, 22), false},
      {"mixed ball, walls", testing::withOctahedra(testing::randomBall(80, 23)), true},
      {"box, walls", testing::creasedBox(3, 0.12, 24), true},
      {"box, open", testing::withOctahedra(testing::creasedBox(3, 0.12, 25)), false}};
  std::printf("%-20s %7s %10s %10s %12s\n", "mesh", "voxel", "staggered", "sampled", "inside");
  for (const Case& test : cases) {
    const ControlAsset asset = randomAsset(test.mesh, test.closedWalls, 31);
    for (const double ratio : kRatios) {
      BakeOptions options = staggered(ratio * meanEdge(asset.mesh) / 2, 1);
      const Certificate c = baked(asset, "velocity", options);
      EXPECT_EQ(grid().method, "circulations");
      EXPECT_LE(c.maxDivergence, kFloatDivergence) << test.name << " " << ratio;
      EXPECT_LE(kFloatDivergence, 2e-6);
      EXPECT_GT(c.insideVoxels, 0u) << test.name << " " << ratio;
      if (test.closedWalls) {
        EXPECT_EQ(c.throughflow, 0);
      }
      // The same field at the same face centres: what sampling leaves.
      options.samplesOnly = true;
      const Certificate sampled = baked(asset, "velocity", options);
      EXPECT_EQ(grid().method, "samples");
      EXPECT_GT(sampled.maxDivergence, 100 * kFloatDivergence);
      std::printf("%-20s %7.1f %10.2g %10.2g %12llu\n", test.name, ratio, c.maxDivergence,
                  sampled.maxDivergence, static_cast<unsigned long long>(c.insideVoxels));
    }
  }
}

TEST_F(Conservative, DerivativeOfAPotentialIsTheSameVelocity) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 32);
  BakeOptions options = staggered(0.11, 2);
  const Certificate velocity = baked(asset, "velocity", options);
  options.derivative = true;
  const Certificate derived = baked(asset, "potential", options);
  EXPECT_EQ(grid().method, "circulations");
  EXPECT_LE(derived.maxDivergence, kFloatDivergence);
  EXPECT_NEAR(derived.energy, velocity.energy, 1e-6 * velocity.energy);
  // With another gauge, tangential along the walls, the same flow.
  ControlAsset gauged = asset;
  const Complex& c = *asset.mesh.complex();
  auto potential = coefficients<1>(asset, asset.form("potential"));
  const auto gradient = d(c, randomForm<0>(c, 33));
  for (Index e = 0; e < c.edgeCount(); ++e) potential[e] += gradient[e];
  gauged.forms = {makeForm<1>("potential", potential)};
  const Certificate same = baked(gauged, "potential", options);
  EXPECT_LE(same.maxDivergence, kFloatDivergence);
  EXPECT_EQ(same.throughflow, 0);
  EXPECT_NEAR(same.energy, velocity.energy, 1e-6 * velocity.energy);
}

/// Rounding of four float values of half a unit in the last place, differences, and three axes.
constexpr double kFloatCurl = 2e-6;

TEST_F(Conservative, GradientsHaveNoCurl) {
  for (const bool octahedra : {false, true}) {
    const ControlMeshInput box = testing::creasedBox(3, 0.1, 41);
    ControlAsset asset{
        "gradient", {}, ControlMesh::build(octahedra ? testing::withOctahedra(box) : box), {}};
    const Complex& c = *asset.mesh.complex();
    const auto f = randomForm<0>(c, 42);
    asset.forms = {makeForm<1>("gradient", d(c, f)), makeForm<0>("height", f)};
    for (const Sampling sampling : {Sampling::Staggered, Sampling::Collocated}) {
      for (const double ratio : kRatios) {
        BakeOptions options = staggered(ratio * meanEdge(asset.mesh) / 4, 2);
        options.sampling = sampling;
        const Certificate found = baked(asset, "gradient", options);
        EXPECT_EQ(grid().method, "differences");
        EXPECT_LE(found.maxCurl, kFloatCurl) << ratio;
        EXPECT_GT(found.insideVoxels, 50u);
        const double energy = found.energy;
        options.samplesOnly = true;
        const Certificate sampled = baked(asset, "gradient", options);
        EXPECT_GT(sampled.maxCurl, 1e-3);
        // Alike where voxels resolve the field; staggered grids differ in what is active.
        if (sampling == Sampling::Collocated && ratio < 1) {
          EXPECT_NEAR(energy, sampled.energy, 0.1 * sampled.energy);
        }
        options.samplesOnly = false;
        options.derivative = true;
        EXPECT_LE(baked(asset, "height", options).maxCurl, kFloatCurl);
        EXPECT_EQ(grid().method, "differences");
      }
    }
  }
}

TEST_F(Conservative, QuadraticPotentialsHaveTheirGradient) {
  // On a lattice the scheme reproduces quadratic functions up to a constant; so do the differences.
  const ControlMesh mesh = ControlMesh::build(
      testing::latticeBlock([](int x, int y, int z) { return x * x + y * y + z * z <= 16; }, 4));
  const DeRham rham(*mesh.complex(), mesh.positions(), 4);
  const auto f =
      rham.vertices([](const Vec3& p) { return p[0] * p[0] - 0.5 * p[1] * p[1] + p[0] * p[2]; });
  const ControlAsset asset{"quadratic", {}, mesh, {makeForm<0>("height", f)}};
  BakeOptions options = staggered(0.23, 2);
  options.derivative = true;
  for (const Sampling sampling : {Sampling::Staggered, Sampling::Collocated}) {
    options.sampling = sampling;
    const Certificate differences = baked(asset, "height", options);
    options.samplesOnly = true;
    const Certificate sampled = baked(asset, "height", options);
    options.samplesOnly = false;
    if (sampling == Sampling::Collocated) {
      EXPECT_NEAR(differences.energy, sampled.energy, 0.005 * sampled.energy);
    }
    EXPECT_NEAR(differences.maxSpeed, sampled.maxSpeed, 0.05 * sampled.maxSpeed);
  }
}

TEST_F(Conservative, FormsWithCirculationAreSampledAndSayWhy) {
  ControlAsset asset{"turning", {}, ControlMesh::build(testing::creasedBox(2, 0.1, 43)), {}};
  const Complex& c = *asset.mesh.complex();
  asset.forms = {makeForm<1>("turning", randomForm<1>(c, 44))};
  BakeOptions options = staggered(0.2, 1);
  baked(asset, "turning", options);
  EXPECT_EQ(grid().method, "samples");
  EXPECT_NE(grid().note.find("not closed"), std::string::npos);
  options.project = true;
  EXPECT_LE(baked(asset, "turning", options).maxCurl, kFloatCurl);
  EXPECT_EQ(grid().method, "differences");
}

TEST_F(Conservative, UpAxisTurnsTheFlow) {
  ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 34);
  BakeOptions options = staggered(0.11, 1);
  const Certificate before = baked(asset, "velocity", options);
  options.target = "houdini";
  options.forms = {"velocity"};
  report_ = bake(asset, options, path("y.vdb"));
  const Certificate turned = verifyVdb(path("y.vdb"), "vel").at(0).certificate;
  EXPECT_LE(turned.maxDivergence, kFloatDivergence);
  EXPECT_NEAR(turned.energy, before.energy, 1e-2 * before.energy);
  EXPECT_EQ(turned.throughflow, 0);
}

TEST_F(Conservative, FogClassGridsAreKnownAsStaggered) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 34);
  BakeOptions options = staggered(0.11, 1);
  options.target = "renderman";
  options.forms = {"velocity"};
  report_ = bake(asset, options, path("fog.vdb"));
  const VerifiedGrid fog = verifyVdb(path("fog.vdb")).at(0);
  EXPECT_EQ(fog.gridClass, "fog volume");
  EXPECT_EQ(fog.certificate.scheme, "FD_1ST");
  EXPECT_LE(fog.certificate.maxDivergence, kFloatDivergence);
}

TEST_F(Conservative, HalfIsReportedAsStored) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 35);
  BakeOptions options = staggered(0.11, 1);
  options.half = true;
  const Certificate stored = baked(asset, "velocity", options);
  EXPECT_TRUE(stored.half);
  // Half floats have eleven digits of two: 2^-12 of the speed per face, six faces.
  EXPECT_GT(stored.maxDivergence, 1e-5);
  EXPECT_LE(stored.maxDivergence, 6.0 / 4096);
  ASSERT_TRUE(grid().certificate);
  EXPECT_EQ(grid().certificate->maxDivergence, stored.maxDivergence);
  EXPECT_EQ(grid().certificate->energy, stored.energy);
}

TEST_F(Conservative, CertificateIsInTheFile) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 36);
  baked(asset, "velocity", staggered(0.11, 1));
  ASSERT_TRUE(grid().certificate);
  int found = 0;
  const auto grids = readVdbInfo(path("out.vdb"));
  for (const VdbMetadata& wanted : toMetadata(*grid().certificate)) {
    for (const VdbMetadata& m : grids.at(0).metadata) {
      if (m.name == wanted.name) ++found;
    }
  }
  EXPECT_EQ(found, 10);
}

TEST_F(Conservative, FormsThatAreNotClosedAreSampledOrProjected) {
  ControlAsset asset =
      randomAsset(testing::withOctahedra(testing::creasedBox(3, 0.1, 6)), true, 37);
  const Complex& c = *asset.mesh.complex();
  auto w = coefficients<2>(asset, asset.form("velocity"));
  Index inner = 0;
  while (c.facetOnBoundary(inner)) ++inner;
  w[inner] += 0.5;
  asset.forms = {makeForm<2>("velocity", w)};
  BakeOptions options = staggered(0.13, 1);
  baked(asset, "velocity", options);
  EXPECT_EQ(grid().method, "samples");
  EXPECT_NE(grid().note.find("not closed: 0.5"), std::string::npos) << grid().note;
  options.project = true;
  const Certificate projected = baked(asset, "velocity", options);
  EXPECT_EQ(grid().method, "circulations");
  EXPECT_NE(grid().note.find("projected"), std::string::npos);
  EXPECT_LE(projected.maxDivergence, kFloatDivergence);
  EXPECT_EQ(projected.throughflow, 0);
}

TEST_F(Conservative, FlowIntoAVoidIsSampledAndSaysWhy) {
  const ControlMesh mesh = ControlMesh::build(testing::latticeBlock(
      [](int x, int y, int z) {
        const int r2 = x * x + y * y + z * z;
        return r2 >= 2 && r2 <= 16;
      },
      4));
  const DeRham rham(*mesh.complex(), mesh.positions(), 10);
  const auto w =
      nearestClosed(*mesh.complex(), mesh.positions(),
                    rham.facets([](const Vec3& p) { return Vec3(p / std::pow(p.norm(), 3)); }));
  const ControlAsset asset{"void", {}, mesh, {makeForm<2>("velocity", w)}};
  const Certificate c = baked(asset, "velocity", staggered(0.5, 1));
  EXPECT_EQ(grid().method, "samples");
  EXPECT_NE(grid().note.find("net flux"), std::string::npos) << grid().note;
  EXPECT_GT(c.maxDivergence, kFloatDivergence);
}

TEST_F(Conservative, FlowAroundAHandleHasNoDivergenceInside) {
  const ControlMesh mesh = ControlMesh::build(testing::latticeBlock(
      [](int x, int y, int z) {
        const int r = std::max(std::abs(x), std::abs(y));
        return r >= 2 && r <= 5 && std::abs(z) <= 2;
      },
      5));
  const DeRham rham(*mesh.complex(), mesh.positions(), 10);
  const auto w = nearestClosed(*mesh.complex(), mesh.positions(), rham.facets([](const Vec3& p) {
    return Vec3(Vec3(-p[1], p[0], 0) / (p[0] * p[0] + p[1] * p[1]));
  }),
                               BoundaryRule::Zero);
  const ControlAsset asset{"ring", {}, mesh, {makeForm<2>("velocity", w)}};
  const Certificate c = baked(asset, "velocity", staggered(0.3, 1));
  EXPECT_EQ(grid().method, "circulations");
  EXPECT_NE(grid().note.find("handle"), std::string::npos) << grid().note;
  EXPECT_LE(c.maxDivergence, kFloatDivergence);
  EXPECT_GT(c.insideVoxels, 1000u);
}

TEST_F(Conservative, VerifyRefusesWhatItCannotRead) {
  EXPECT_THROW(verifyVdb(path("absent.vdb")), InputError);
  std::ofstream(path("text.vdb")) << "no grid";
  EXPECT_THROW(verifyVdb(path("text.vdb")), InputError);
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 38);
  baked(asset, "velocity", staggered(0.3, 1));
  EXPECT_THROW(verifyVdb(path("out.vdb"), "other"), InputError);
}

}  // namespace
}  // namespace octet
