// SPDX-License-Identifier: Apache-2.0
// Parts of bakes are those of the whole, leaf by leaf, and make the whole again.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <octet/converters/vdb/bake_part.h>
#include <octet/converters/vdb/merge_vdb.h>
#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"

namespace octet {
namespace {

using testing::randomForm;
namespace fs = std::filesystem;

class Shards : public ::testing::Test {
 protected:
  Shards() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("octet_" + std::string(info->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  ~Shards() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  static std::string bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// The files of shards of a bake, of one frame where there are several.
  std::vector<std::string> bakeShards(const ControlAsset& asset, BakeOptions options, int count,
                                      std::size_t frame = 0) {
    std::vector<std::string> parts;
    for (int number = 1; number <= count; ++number) {
      options.shard = Shard{number, count};
      const auto report = bake(asset, options, path("part" + std::to_string(number) + ".vdb"));
      EXPECT_EQ(report.part, "shard " + std::to_string(number) + " of " + std::to_string(count));
      parts.push_back(report.files.at(frame).path);
    }
    return parts;
  }

  fs::path folder_;
};

/// A curved mesh with a flow, its potential, a gradient and a density, all random.
ControlAsset randomAsset(bool closedWalls, std::uint32_t seed) {
  ControlAsset asset{
      "random", {}, ControlMesh::build(testing::withOctahedra(testing::randomBall(30, seed))), {}};
  const Complex& c = *asset.mesh.complex();
  auto potential = randomForm<1>(c, seed);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (closedWalls && c.edgeOnBoundary(e)) potential[e] = 0;
  }
  const auto height = randomForm<0>(c, seed + 1);
  asset.forms = {makeForm<2>("velocity", d(c, potential)), makeForm<0>("height", height),
                 makeForm<1>("gradient", d(c, height)),
                 makeForm<3>("density", randomForm<3>(c, seed + 2))};
  return asset;
}

BakeOptions optionsOf(const std::string& form, int resolution, Sampling sampling) {
  BakeOptions options;
  options.forms = {form};
  options.resolution = resolution;
  options.levels = 1;
  options.sampling = sampling;
  return options;
}

/// Every leaf of a part is one of the whole, to the bit. @return how many there are
template <typename Grid>
std::size_t compareLeaves(const openvdb::GridBase::Ptr& part, const openvdb::GridBase::Ptr& whole) {
  const auto some = openvdb::gridPtrCast<Grid>(part), all = openvdb::gridPtrCast<Grid>(whole);
  if (!some) return 0;
  std::size_t count = 0;
  for (auto leaf = some->tree().cbeginLeaf(); leaf; ++leaf, ++count) {
    const auto* other = all->tree().probeConstLeaf(leaf->origin());
    if (!other || leaf->getValueMask() != other->getValueMask() ||
        std::memcmp(leaf->buffer().data(), other->buffer().data(),
                    512 * sizeof(typename Grid::ValueType)) != 0) {
      ADD_FAILURE() << "leaf at " << leaf->origin();
    }
  }
  return count;
}

openvdb::GridPtrVec gridsOf(const std::string& path) {
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);
  return *file.getGrids();
}

/// @return leaves of the part that were compared, of all grids
std::size_t compareFiles(const std::string& part, const std::string& whole) {
  const openvdb::GridPtrVec some = gridsOf(part), all = gridsOf(whole);
  EXPECT_EQ(some.size(), all.size());
  std::size_t count = 0;
  for (std::size_t k = 0; k < some.size(); ++k) {
    count += compareLeaves<openvdb::Vec3SGrid>(some[k], all[k]);
    count += compareLeaves<openvdb::FloatGrid>(some[k], all[k]);
  }
  return count;
}

std::size_t leavesIn(const std::string& path) {
  std::size_t count = 0;
  for (const auto& grid : gridsOf(path)) {
    if (const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) {
      count += vectors->tree().leafCount();
    } else {
      count += openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree().leafCount();
    }
  }
  return count;
}

struct ShardCase {
  const char* name;
  const char* form;
  Sampling sampling;
  BakeMethod method;
  bool closedWalls;
  const char* target;
  GridMethod expected;
};

TEST_F(Shards, MakeTheWholeToTheByte) {
  const auto staggered = Sampling::Staggered, collocated = Sampling::Collocated;
  const ShardCase cases[] = {
      {"staggered, walls", "velocity", staggered, BakeMethod::Auto, true, "openvdb",
       GridMethod::Circulations},
      {"staggered, open", "velocity", staggered, BakeMethod::Auto, false, "houdini",
       GridMethod::Circulations},
      {"means", "velocity", collocated, BakeMethod::Conservative, false, "blender",
       GridMethod::Circulations},
      {"samples", "velocity", collocated, BakeMethod::Samples, true, "openvdb",
       GridMethod::Samples},
      {"staggered samples", "velocity", staggered, BakeMethod::Samples, false, "openvdb",
       GridMethod::Samples},
      {"curl-free", "gradient", collocated, BakeMethod::Auto, false, "openvdb",
       GridMethod::Differences},
      {"curl-free, staggered", "gradient", staggered, BakeMethod::Auto, false, "openvdb",
       GridMethod::Differences},
      {"0-form", "height", collocated, BakeMethod::Auto, false, "openvdb", GridMethod::None},
      {"3-form", "density", collocated, BakeMethod::Auto, false, "openvdb", GridMethod::None}};
  for (const ShardCase& test : cases) {
    const ControlAsset asset = randomAsset(test.closedWalls, 7);
    BakeOptions options = optionsOf(test.form, 60, test.sampling);
    options.method = test.method;
    options.target = test.target;
    const BakeReport whole = bake(asset, options, path("whole.vdb"));
    EXPECT_EQ(whole.files[0].grids[0].method, test.expected) << test.name;
    const std::size_t leaves = leavesIn(path("whole.vdb"));
    ASSERT_GT(leaves, 100u);
    for (const int count : {2, 3, 7}) {
      SCOPED_TRACE(std::string(test.name) + ", " + std::to_string(count));
      std::vector<std::string> parts = bakeShards(asset, options, count);
      std::size_t sum = 0;
      for (const std::string& part : parts) {
        const std::size_t some = compareFiles(part, path("whole.vdb"));
        // About equal work, as far as few leaves can be cut.
        EXPECT_GT(3 * static_cast<std::size_t>(count) * some, leaves);
        EXPECT_LT(2 * static_cast<std::size_t>(count) * some, 5 * leaves);
        sum += some;
      }
      EXPECT_EQ(sum, leaves);
      std::reverse(parts.begin(), parts.end());
      const BakedFile merged = mergeVdb(parts, path("merged.vdb"));
      EXPECT_TRUE(bytes(path("merged.vdb")) == bytes(path("whole.vdb")));
      const VdbGridInfo &found = merged.grids.at(0), &expected = whole.files[0].grids[0];
      EXPECT_EQ(found.method, expected.method);
      EXPECT_EQ(found.sampledVoxels, expected.sampledVoxels);
      EXPECT_EQ(found.activeVoxels, expected.activeVoxels);
      ASSERT_EQ(found.certificate.has_value(), expected.certificate.has_value());
      if (found.certificate) {
        EXPECT_EQ(found.certificate->rmsDivergence, expected.certificate->rmsDivergence);
        EXPECT_FALSE(found.certificate->partial);
      }
    }
  }
}

TEST_F(Shards, OfSequencesAndOfAllForms) {
  ControlAsset asset = randomAsset(false, 9);
  Form& velocity = asset.forms[0];
  std::vector<double> twice = velocity.values;
  for (double& x : twice) x *= 2;
  velocity.frames = {{1, velocity.values}, {2, twice}};
  velocity.values.clear();
  BakeOptions options = optionsOf("", 40, Sampling::Staggered);
  options.forms.clear();
  options.half = true;
  const BakeReport whole = bake(asset, options, path("whole.vdb"));
  ASSERT_EQ(whole.files.size(), 2u);
  std::vector<std::vector<std::string>> parts;
  for (std::size_t frame = 0; frame < 2; ++frame) {
    parts.push_back(bakeShards(asset, options, 3, frame));
    const BakedFile merged = mergeVdb(parts.back(), path("merged.vdb"));
    EXPECT_EQ(merged.frame, whole.files[frame].frame);
    EXPECT_EQ(merged.grids.size(), 4u);
    EXPECT_TRUE(bytes(path("merged.vdb")) == bytes(whole.files[frame].path));
  }
  // A frame that is another's does not go with them.
  parts[0][1] = parts[1][1];
  EXPECT_THROW(mergeVdb(parts[0], path("never.vdb")), InputError);
  EXPECT_FALSE(fs::exists(path("never.vdb")));
}

TEST_F(Shards, DoNotDependOnThreads) {
  const ControlAsset asset = randomAsset(true, 11);
  BakeOptions options = optionsOf("velocity", 50, Sampling::Staggered);
  options.shard = Shard{2, 3};
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    bake(asset, options, path("of" + std::to_string(threads) + ".vdb"));
  }
  EXPECT_TRUE(bytes(path("of1.vdb")) == bytes(path("of2.vdb")));
}

TEST_F(Shards, CertificatesOfPartsAreOfWhatTheyKnow) {
  const ControlAsset asset = randomAsset(true, 13);
  BakeOptions options = optionsOf("velocity", 60, Sampling::Staggered);
  const Certificate whole = *bake(asset, options, path("whole.vdb")).files[0].grids[0].certificate;
  EXPECT_FALSE(whole.partial);
  std::uint64_t active = 0, inside = 0;
  double energy = 0, outflow = 0, throughflow = 0;
  for (const std::string& part : bakeShards(asset, options, 3)) {
    // As verify finds it in the file, too.
    const Certificate c = verifyVdb(part).at(0).certificate;
    EXPECT_TRUE(c.partial);
    EXPECT_LE(c.maxDivergence, kFloatDivergence);
    EXPECT_GT(c.insideVoxels, 0u);
    active += c.activeVoxels;
    inside += c.insideVoxels;
    energy += c.energy;
    outflow += c.outflow;
    throughflow += c.throughflow;
  }
  EXPECT_EQ(active, whole.activeVoxels);
  EXPECT_LT(inside, whole.insideVoxels);
  EXPECT_GT(inside, whole.insideVoxels / 2);
  EXPECT_NEAR(energy, whole.energy, 1e-9 * whole.energy);
  // Nothing is counted as flowing out through the cuts.
  EXPECT_NEAR(throughflow, whole.throughflow, 1e-9 * whole.maxSpeed);
  EXPECT_NEAR(outflow, whole.outflow, 1e-9 * whole.maxSpeed);
}

TEST_F(Shards, ARegionIsItsLeaves) {
  const ControlAsset asset = randomAsset(false, 15);
  for (const char* target : {"openvdb", "houdini"}) {
    BakeOptions options = optionsOf("velocity", 60, Sampling::Collocated);
    options.target = target;
    const BakeReport whole = bake(asset, options, path("whole.vdb"));
    options.region = Box{Vec3(-0.4, -0.2, -0.1), Vec3(0.1, 0.5, 0.3)};
    const BakeReport part = bake(asset, options, path("part.vdb"));
    EXPECT_EQ(part.part, "region");
    EXPECT_TRUE(part.files[0].grids[0].certificate->partial);
    const std::size_t leaves = compareFiles(path("part.vdb"), path("whole.vdb"));
    EXPECT_GT(leaves, 8u);
    EXPECT_LT(leaves, leavesIn(path("whole.vdb")) / 2);
    // All of the box is there, and less than a leaf beyond it.
    const AxisTurn turn{'Z', std::string(target) == "houdini" ? 'Y' : 'Z'};
    const Box box = turnedBox(*options.region, turn);
    const double h = whole.voxelSize;
    const auto all = openvdb::gridPtrCast<openvdb::Vec3SGrid>(gridsOf(path("whole.vdb"))[0]);
    const auto some = openvdb::gridPtrCast<openvdb::Vec3SGrid>(gridsOf(path("part.vdb"))[0]);
    std::uint64_t inBox = 0;
    for (auto it = all->cbeginValueOn(); it; ++it) {
      const openvdb::Coord ijk = it.getCoord();
      const Vec3 x = h * Vec3(ijk[0], ijk[1], ijk[2]);
      const bool has = some->tree().isValueOn(ijk);
      inBox += box.contains(x);
      if (box.contains(x)) {
        EXPECT_TRUE(has) << ijk;
      }
      const Box around{Vec3(box.min.array() - 8 * h), Vec3(box.max.array() + 8 * h)};
      if (!around.contains(x)) {
        EXPECT_FALSE(has) << ijk;
      }
    }
    EXPECT_GT(inBox, 1000u);
    EXPECT_THROW(mergeVdb({path("part.vdb")}, path("never.vdb")), InputError);
  }
}

TEST_F(Shards, RefusesPartsThatThereAreNot) {
  const ControlAsset asset = randomAsset(false, 17);
  const auto refused = [&](std::optional<Shard> shard, std::optional<Box> region) {
    BakeOptions options = optionsOf("velocity", 20, Sampling::Collocated);
    options.shard = shard;
    options.region = region;
    EXPECT_THROW(bake(asset, options, path("never.vdb")), InputError);
  };
  for (const auto& [number, count] : {std::pair{0, 3}, {4, 3}, {1, 0}, {-1, 2}}) {
    refused(Shard{number, count}, std::nullopt);
  }
  refused(std::nullopt, Box{Vec3(0, 0, 0), Vec3(1, 1, -1)});
  refused(std::nullopt, Box{Vec3(90, 90, 90), Vec3(91, 91, 91)});
  refused(std::nullopt, Box{Vec3(NAN, 0, 0), Vec3(1, 1, 1)});
  refused(Shard{1, 2}, Box{Vec3(0, 0, 0), Vec3(1, 1, 1)});
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Shards, MoreThanThereAreLeaves) {
  const ControlAsset asset = randomAsset(true, 19);
  const BakeOptions options = optionsOf("velocity", 9, Sampling::Staggered);
  bake(asset, options, path("whole.vdb"));
  ASSERT_LT(leavesIn(path("whole.vdb")), 30u);
  mergeVdb(bakeShards(asset, options, 30), path("merged.vdb"));
  EXPECT_TRUE(bytes(path("merged.vdb")) == bytes(path("whole.vdb")));
}

TEST(GridPart, IsReadAsItWasWritten) {
  const IndexBox window{{-kTileLimit, 3, -2}, {5, kTileLimit - 1, 7}};
  for (const std::optional<Shard> shard : {std::optional<Shard>(Shard{2, 7}), {}}) {
    std::map<std::string, std::string> metadata;
    for (const VdbMetadata& m : toMetadata(GridPart{shard, "tag", window})) {
      EXPECT_EQ(m.name.rfind(kPartMetadata, 0), 0u);
      metadata[m.name] = std::get<std::string>(m.value);
    }
    const auto read = [&] {
      return readPart([&](const std::string& name) { return metadata[name]; });
    };
    const auto part = read();
    ASSERT_TRUE(part);
    EXPECT_EQ(part->bake, "tag");
    EXPECT_EQ(part->window.min, window.min);
    EXPECT_EQ(part->window.max, window.max);
    EXPECT_EQ(part->shard.has_value(), shard.has_value());
    metadata["octet_part_window"] = "1 2 3";
    EXPECT_THROW(read(), InputError);
  }
  EXPECT_FALSE(readPart([](const std::string&) { return ""; }));
}

TEST(GridPart, WindowsCoverAllOrNot) {
  const auto below = [](int axis, GridIndex last) {
    IndexBox box = kAllTiles;
    box.max[static_cast<std::size_t>(axis)] = last;
    return box;
  };
  const auto above = [](int axis, GridIndex first) {
    IndexBox box = kAllTiles;
    box.min[static_cast<std::size_t>(axis)] = first;
    return box;
  };
  EXPECT_TRUE(coverAll({kAllTiles}));
  EXPECT_TRUE(coverAll({below(0, 4), above(0, 5)}));
  EXPECT_FALSE(coverAll({below(0, 4), above(0, 6)}));  // a gap
  EXPECT_FALSE(coverAll({below(0, 4), above(0, 4)}));  // twice
  EXPECT_FALSE(coverAll({below(0, 4)}));
  const IndexBox left = below(0, -3), right = above(0, -2);
  EXPECT_TRUE(coverAll({left, intersection(right, below(2, 9)), intersection(right, above(2, 10)),
                        IndexBox{{0, 0, 0}, {-1, -1, -1}}}));
  EXPECT_FALSE(
      coverAll({left, intersection(right, below(2, 9)), intersection(right, above(1, 10))}));
}

/// Volumes of bricks of a domain are about equal, whatever its shape.
TEST(DomainShape, IsCutIntoEqualParts) {
  const ControlMesh ball = ControlMesh::build(testing::randomBall(150, 3));
  const DomainShape shape(*ball.complex(), ball.positions(), {});
  EXPECT_NEAR(shape.share(shape.box()), 1, 1e-9);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double part : {0.2, 0.5, 0.9}) {
      Box below = shape.box();
      below.max[axis] = shape.cut(shape.box(), axis, part);
      EXPECT_NEAR(shape.share(below), part, 0.02);
    }
  }
}

/// A box: voxels and leaves are known.
TEST(DomainShape, ForeseesCubes) {
  const ControlMesh box = ControlMesh::build(testing::creasedBox(2, 0, 1));
  const DomainShape shape(*box.complex(), box.positions(), {});
  const Vec3 size = shape.box().size();
  EXPECT_NEAR(shape.volume(), size.prod(), 1e-9);
  for (const double edge : {0.05, 0.3}) {
    const double expected = (size.array() + edge).prod() / std::pow(0.1, 3);
    EXPECT_NEAR(shape.cubes(0.1, edge), expected, 1e-9 * expected);
  }
}

}  // namespace
}  // namespace octet
