// SPDX-License-Identifier: Apache-2.0
// Conservative bakes and their certificate, from control asset to file and back.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <octet/converters/vdb/bake.h>
#include <octet/converters/vdb/certificate.h>
#include <octet/converters/vdb/vdb_sampler.h>
#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/topology/mean_edge.h>
#ifdef OCTETVDB_WITH_THESIS
#include <octet/core/thesis/thesis_subdivision.h>
#endif

#include "tests/support/forms.h"
#include "tests/support/meshes.h"

namespace octet {
namespace {

using testing::randomForm;

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
  /// The reason of this kind that the grid was made so; null when there is none.
  template <typename Reason>
  const Reason* reason() const {
    for (const BakeReason& any : grid().reasons) {
      if (const auto* const found = std::get_if<Reason>(&any)) return found;
    }
    return nullptr;
  }

  fs::path folder_;
  BakeReport report_;
};

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

double meanEdge(const ControlMesh& mesh) { return meanEdge(*mesh.complex(), mesh.positions()); }

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
      EXPECT_EQ(grid().method, GridMethod::Circulations);
      EXPECT_LE(c.maxDivergence, kFloatDivergence) << test.name << " " << ratio;
      EXPECT_LE(kFloatDivergence, 2e-6);
      EXPECT_GT(c.insideVoxels, 0u) << test.name << " " << ratio;
      if (test.closedWalls) {
        EXPECT_EQ(c.throughflow, 0);
      }
      // The same field at the same face centres: what sampling leaves.
      options.method = BakeMethod::Samples;
      const Certificate sampled = baked(asset, "velocity", options);
      EXPECT_EQ(grid().method, GridMethod::Samples);
      EXPECT_GT(sampled.maxDivergence, 100 * kFloatDivergence);
      std::printf("%-20s %7.1f %10.2g %10.2g %12llu\n", test.name, ratio, c.maxDivergence,
                  sampled.maxDivergence, static_cast<unsigned long long>(c.insideVoxels));
    }
  }
}

// ---- Collocated fluxes --------------------------------------------------------------------------

using Ijk = std::array<std::int32_t, 3>;

Ijk beside(Ijk ijk, int axis, int by) {
  ijk[axis] += by;
  return ijk;
}

/// The active voxels of a grid in a file.
class StoredVoxels {
 public:
  /// @param shift  world position of voxel (0, 0, 0)
  StoredVoxels(const std::string& path, const VdbGridInfo& grid, double shift = 0) {
    const VdbSampler sampler(path, grid.name);
    Ijk at;
    for (at[0] = grid.indexMin[0]; at[0] <= grid.indexMax[0]; ++at[0]) {
      for (at[1] = grid.indexMin[1]; at[1] <= grid.indexMax[1]; ++at[1]) {
        for (at[2] = grid.indexMin[2]; at[2] <= grid.indexMax[2]; ++at[2]) {
          const Vec3 point = Vec3(at[0], at[1], at[2]) * grid.voxelSize + Vec3::Constant(shift);
          Vec3 value;
          // The sampler interpolates, in doubles; stored are floats.
          if (sampler.sample(point, value.data())) values_[at] = value.cast<float>().cast<double>();
        }
      }
    }
  }

  const std::map<Ijk, Vec3>& values() const { return values_; }
  bool has(const Ijk& ijk) const { return values_.count(ijk) != 0; }
  const Vec3& at(const Ijk& ijk) const { return values_.at(ijk); }
  double largest() const {
    double result = 0;
    for (const auto& [ijk, value] : values_) result = std::max(result, value.norm());
    return result;
  }
  /// Central differences, times voxel size.
  double divergence(const Ijk& ijk) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += at(beside(ijk, k, 1))[k] - at(beside(ijk, k, -1))[k];
    return sum / 2;
  }

 private:
  std::map<Ijk, Vec3> values_;
};

/// @param ratio  voxels per mean fine edge
BakeOptions collocated(const ControlMesh& mesh, double ratio, int levels) {
  RefinerOptions refinement;
  refinement.levels = levels;
  const Refiner refiner(mesh, refinement);
  const Limit limit(refiner);
  BakeOptions options = staggered(ratio * meanEdge(refiner.finest(), limit.positions()), levels);
  options.sampling = Sampling::Collocated;
  return options;
}

/// Voxels per mean fine edge that circulations are automatic for.
constexpr double kCollocatedRatios[] = {0.42, 0.55, 0.72};

TEST_F(Conservative, CollocatedFluxesHaveNoDivergenceInside) {
  struct Case {
    const char* name;
    ControlMeshInput mesh;
    bool closedWalls;
    int levels;
  };
  const std::vector<Case> cases = {
      {"ball, walls", testing::randomBall(150, 21), true, 1},
      {"mixed ball, open", testing::withOctahedra(testing::randomBall(150, 22)), false, 1},
      {"box, walls", testing::creasedBox(3, 0.12, 24), true, 2}};
  std::printf("%-20s %7s %9s %9s %12s %12s\n", "mesh", "voxel", "max", "sampled", "free",
              "of inside");
  for (const Case& test : cases) {
    const ControlAsset asset = randomAsset(test.mesh, test.closedWalls, 31);
    for (const double ratio : kCollocatedRatios) {
      SCOPED_TRACE(std::string(test.name) + " " + std::to_string(ratio));
      BakeOptions options = collocated(asset.mesh, ratio, test.levels);
      const Certificate c = baked(asset, "velocity", options);
      const VdbGridInfo info = grid();
      EXPECT_EQ(info.method, GridMethod::Circulations);
      const StoredVoxels ours(path("out.vdb"), info);
      options.method = BakeMethod::Samples;
      const Certificate sampled = baked(asset, "velocity", options);
      EXPECT_EQ(grid().method, GridMethod::Samples);
      EXPECT_EQ(grid().sampledVoxels, grid().activeVoxels);
      const StoredVoxels samples(path("out.vdb"), grid());

      // What is active is what samples make active; the report says how many remained samples.
      ASSERT_EQ(ours.values().size(), samples.values().size());
      const auto circulates = [&](const Ijk& ijk) { return ours.at(ijk) != samples.at(ijk); };
      std::uint64_t circulating = 0, inside = 0;
      for (const auto& [ijk, value] : ours.values()) {
        ASSERT_TRUE(samples.has(ijk));
        if (circulates(ijk)) ++circulating;
        bool whole = true;
        for (int k = 0; k < 3; ++k) {
          for (const int side : {-1, 1}) {
            const Ijk other = beside(ijk, k, side);
            whole = whole && ours.has(other) && circulates(other);
          }
        }
        if (!whole) continue;
        ++inside;
        ASSERT_LE(std::abs(ours.divergence(ijk)), kFloatDivergence * ours.largest());
      }
      EXPECT_EQ(circulating, info.activeVoxels - info.sampledVoxels);
      EXPECT_GT(inside, 20u);
      EXPECT_GE(c.freeVoxels, inside);
      EXPECT_LT(c.rmsDivergence, sampled.rmsDivergence);
      EXPECT_LT(sampled.freeVoxels, sampled.insideVoxels / 10);
      std::printf("%-20s %7.2f %9.2g %9.2g %12llu %12llu\n", test.name, ratio, c.maxDivergence,
                  sampled.maxDivergence, static_cast<unsigned long long>(c.freeVoxels),
                  static_cast<unsigned long long>(c.insideVoxels));
    }
  }
}

TEST_F(Conservative, CollocatedFluxesComeNearSamplesWithOrderTwo) {
  const ControlMesh mesh = ControlMesh::build(
      testing::latticeBlock([](int x, int y, int z) { return x * x + y * y + z * z <= 10; }, 4));
  const Complex& c = *mesh.complex();
  const auto w = d(c, DeRham(c, mesh.positions(), 8).edges([](const Vec3& p) {
    return Vec3(std::sin(0.5 * p[1]) * std::sin(p[2]), std::sin(0.6 * p[0]) * std::cos(0.5 * p[2]),
                std::sin(0.5 * p[0]) * std::cos(0.7 * p[1]));
  }));
  const ControlAsset asset{"lattice", {}, mesh, {makeForm<2>("velocity", w)}};
  double before = 0;
  for (const int levels : {1, 2, 3}) {
    BakeOptions options = collocated(mesh, 0.6, levels);
    baked(asset, "velocity", options);
    ASSERT_EQ(grid().method, GridMethod::Circulations);
    const StoredVoxels ours(path("out.vdb"), grid());
    options.method = BakeMethod::Samples;
    baked(asset, "velocity", options);
    const StoredVoxels samples(path("out.vdb"), grid());
    // Where all three levels have circulations.
    double sum = 0;
    int n = 0;
    for (const auto& [ijk, value] : ours.values()) {
      if ((Vec3(ijk[0], ijk[1], ijk[2]) * grid().voxelSize).norm() > 1) continue;
      ASSERT_TRUE(value != samples.at(ijk));
      sum += (value - samples.at(ijk)).squaredNorm();
      ++n;
    }
    ASSERT_GT(n, 30);
    const double difference = std::sqrt(sum / n) / samples.largest();
    std::printf("%d levels: %.2g of the largest speed\n", levels, difference);
    if (before > 0) {
      EXPECT_GT(std::log2(before / difference), 1.75);
    }
    before = difference;
  }
  EXPECT_LT(before, 2e-3);
}

TEST_F(Conservative, CollocatedFluxesDoNotDependOnThreads) {
  // Large enough that two threads share it.
  const ControlAsset asset = randomAsset(testing::randomBall(100, 21), true, 31);
  const BakeOptions options = collocated(asset.mesh, 0.45, 2);
  const auto bytes = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    baked(asset, "velocity", options);
    EXPECT_EQ(grid().method, GridMethod::Circulations);
    std::ifstream file(path("out.vdb"), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string one = bytes(1);
  EXPECT_GT(one.size(), 10000u);
  EXPECT_TRUE(one == bytes(2));
}

TEST_F(Conservative, CollocatedFluxesFollowTheTarget) {
  const ControlAsset asset = randomAsset(testing::randomBall(60, 21), true, 34);
  BakeOptions options = collocated(asset.mesh, 0.5, 1);
  const Certificate plain = baked(asset, "velocity", options);
  const StoredVoxels voxels(path("out.vdb"), grid());
  EXPECT_GT(plain.freeVoxels, 20u);
  const auto bakedFor = [&](const char* target, double shift) {
    options.target = target;
    options.forms = {"velocity"};
    report_ = bake(asset, options, path("target.vdb"));
    EXPECT_NEAR(static_cast<double>(grid().certificate->freeVoxels),
                static_cast<double>(plain.freeVoxels), 2);
    return StoredVoxels(path("target.vdb"), grid(), shift);
  };
  // Blender's grid lies half a voxel aside, and is the same.
  const StoredVoxels shifted = bakedFor("blender", -options.voxelSize / 2);
  EXPECT_TRUE(shifted.values() == voxels.values());
  // Houdini's is turned: (x, y, z) -> (x, z, -y), of places and of components.
  const StoredVoxels turned = bakedFor("houdini", 0);
  ASSERT_EQ(turned.values().size(), voxels.values().size());
  for (const auto& [ijk, value] : voxels.values()) {
    const Ijk at = {ijk[0], ijk[2], -ijk[1]};
    ASSERT_TRUE(turned.has(at));
    ASSERT_LE((turned.at(at) - Vec3(value[0], value[2], -value[1])).norm(),
              1e-6 * voxels.largest());
  }
}

TEST_F(Conservative, CollocatedFluxesAreSampledWhereThatIsNearer) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 34);
  for (const double ratio : {0.25, 0.9}) {
    BakeOptions options = collocated(asset.mesh, ratio, 2);
    const Certificate sampled = baked(asset, "velocity", options);
    EXPECT_EQ(grid().method, GridMethod::Samples);
    const auto* const unlike = reason<VoxelsUnlikeEdges>();
    ASSERT_TRUE(unlike);
    EXPECT_NEAR(unlike->voxelsPerEdge, ratio, 1e-12);
    options.method = BakeMethod::Conservative;
    const Certificate forced = baked(asset, "velocity", options);
    EXPECT_EQ(grid().method, GridMethod::Circulations);
    EXPECT_GT(forced.freeVoxels, sampled.freeVoxels);
  }
}

#ifdef OCTETVDB_WITH_THESIS
BoundaryChoice byThesis(ThesisMethod method) {
  BoundaryChoice choice;
  choice.subdivide = [method](const ControlMesh& mesh, const RefinerOptions& options,
                              const Context& context) {
    return subdivideByThesis(mesh, method, options, context);
  };
  return choice;
}
#endif

TEST_F(Conservative, ConservativeIsRefusedWhereItCannotBe) {
  ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 34);
  const Complex& c = *asset.mesh.complex();
  asset.forms.push_back(makeForm<2>("open", randomForm<2>(c, 1)));
  asset.forms.push_back(makeForm<1>("turning", randomForm<1>(c, 2)));
  BakeOptions options = collocated(asset.mesh, 0.5, 1);
  options.method = BakeMethod::Conservative;
  const auto refuses = [&](const char* form, const char* why) {
    try {
      baked(asset, form, options);
      ADD_FAILURE() << form << " was baked";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(why), std::string::npos) << e.what();
    }
    EXPECT_FALSE(fs::exists(path("out.vdb")));
  };
  for (const Sampling sampling : {Sampling::Staggered, Sampling::Collocated}) {
    options.sampling = sampling;
    refuses("open", "not closed");
    refuses("turning", "not closed");
  }
  options.reconstruction = Reconstruction::Whitney;
  refuses("velocity", "limit reconstruction");
#ifdef OCTETVDB_WITH_THESIS
  options.reconstruction = Reconstruction::Limit;
  options.boundary = byThesis(ThesisMethod::Projection);
  refuses("velocity", "commutes");
#endif
}

#ifdef OCTETVDB_WITH_THESIS
TEST_F(Conservative, ExpansionHasPotentialsToo) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 34);
  BakeOptions options = collocated(asset.mesh, 0.5, 1);
  options.method = BakeMethod::Conservative;
  options.boundary = byThesis(ThesisMethod::Expansion);
  options.sampling = Sampling::Staggered;
  EXPECT_LE(baked(asset, "velocity", options).maxDivergence, kFloatDivergence);
  EXPECT_EQ(grid().method, GridMethod::Circulations);
}
#endif

TEST_F(Conservative, DerivativeOfAPotentialIsTheSameVelocity) {
  const ControlAsset asset = randomAsset(testing::creasedBox(2, 0.1, 1), true, 32);
  BakeOptions options = staggered(0.11, 2);
  const Certificate velocity = baked(asset, "velocity", options);
  options.derivative = true;
  const Certificate derived = baked(asset, "potential", options);
  EXPECT_EQ(grid().method, GridMethod::Circulations);
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
        EXPECT_EQ(grid().method, GridMethod::Differences);
        EXPECT_LE(found.maxCurl, kFloatCurl) << ratio;
        EXPECT_GT(found.insideVoxels, 50u);
        const double energy = found.energy;
        options.method = BakeMethod::Samples;
        const Certificate sampled = baked(asset, "gradient", options);
        EXPECT_GT(sampled.maxCurl, 1e-3);
        // Alike where voxels resolve the field; staggered grids differ in what is active.
        if (sampling == Sampling::Collocated && ratio < 1) {
          EXPECT_NEAR(energy, sampled.energy, 0.1 * sampled.energy);
        }
        options.method = BakeMethod::Auto;
        options.derivative = true;
        EXPECT_LE(baked(asset, "height", options).maxCurl, kFloatCurl);
        EXPECT_EQ(grid().method, GridMethod::Differences);
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
    options.method = BakeMethod::Samples;
    const Certificate sampled = baked(asset, "height", options);
    options.method = BakeMethod::Auto;
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
  EXPECT_EQ(grid().method, GridMethod::Samples);
  EXPECT_TRUE(reason<NotClosed>());
  options.project = true;
  EXPECT_LE(baked(asset, "turning", options).maxCurl, kFloatCurl);
  EXPECT_EQ(grid().method, GridMethod::Differences);
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
  // Collocated circulations keep their name; that they are no longer free is said.
  options = collocated(asset.mesh, 0.45, 2);
  const Certificate full = baked(asset, "velocity", options);
  EXPECT_GT(full.freeVoxels, full.insideVoxels / 5);
  EXPECT_EQ(grid().method, GridMethod::Circulations);
  options.half = true;
  const Certificate half = baked(asset, "velocity", options);
  EXPECT_EQ(grid().method, GridMethod::Circulations);
  EXPECT_LT(half.freeVoxels, half.insideVoxels / 20);
  ASSERT_TRUE(grid().certificate);
  EXPECT_EQ(grid().certificate->maxDivergence, half.maxDivergence);
  EXPECT_EQ(grid().certificate->energy, half.energy);
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
  EXPECT_EQ(found, 11);
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
  EXPECT_EQ(grid().method, GridMethod::Samples);
  ASSERT_TRUE(reason<NotClosed>());
  EXPECT_NEAR(reason<NotClosed>()->largest, 0.5, 1e-9);
  options.project = true;
  const Certificate projected = baked(asset, "velocity", options);
  EXPECT_EQ(grid().method, GridMethod::Circulations);
  EXPECT_TRUE(reason<Projected>());
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
  EXPECT_EQ(grid().method, GridMethod::Samples);
  ASSERT_TRUE(reason<LeavesVoid>());
  EXPECT_FALSE(reason<LeavesVoid>()->fluxes.empty());
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
  EXPECT_EQ(grid().method, GridMethod::Circulations);
  EXPECT_TRUE(reason<AroundHandle>());
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
