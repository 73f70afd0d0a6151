// SPDX-License-Identifier: Apache-2.0
// What files of a bake are told apart by: whatever changes a byte changes the tag, and nothing else
// does. And the heads of files, which tell whole ones from cut ones without reading them.
#include <filesystem>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include <octet/converters/vdb/bake.h>
#include <octet/converters/vdb/content_tag.h>
#include <octet/converters/vdb/vdb_head.h>
#include <octet/core/base/system.h>

namespace octet {
namespace {

namespace fs = std::filesystem;

ControlAsset tetrahedron() {
  ControlMeshInput input;
  input.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  input.tets = {{0, 1, 2, 3}};
  ControlAsset asset;
  asset.name = "one";
  asset.mesh = ControlMesh::build(std::move(input));
  Form form;
  form.name = "flow";
  form.degree = 2;
  form.simplices = {0, 1};
  form.signs = {1, 1};
  form.frames = {{1, {1.0, 2.0}}, {2, {1.0, 3.0}}};
  asset.forms = {form};
  return asset;
}

std::string tagOf(const ControlAsset& asset, const BakeOptions& options, int frame,
                  ResolutionPlan plan = {0.1, 2, 100, 0.1, 1e6}) {
  return ContentTags(asset, options, plan, {{&asset.forms[0], "flow", BoundaryMode::Open}})
      .of(frame);
}

TEST(ContentTag, TellsWhatChangesAByte) {
  const ControlAsset asset = tetrahedron();
  const BakeOptions options;
  std::set<std::string> tags = {tagOf(asset, options, 1)};
  const auto differs = [&](const char* what, const std::string& tag) {
    EXPECT_TRUE(tags.insert(tag).second) << what;
  };
  differs("frame", tagOf(asset, options, 2));
  differs("voxel size", tagOf(asset, options, 1, {0.2, 2, 100, 0.1, 1e6}));
  differs("levels", tagOf(asset, options, 1, {0.1, 3, 100, 0.1, 1e6}));
  ControlAsset changed = asset;
  changed.name = "other";
  differs("name", tagOf(changed, options, 1));
  changed = asset;
  changed.units.framesPerSecond = 25;
  differs("units", tagOf(changed, options, 1));
  changed = asset;
  changed.forms[0].frames[1][1] = std::nextafter(2.0, 3.0);
  differs("value", tagOf(changed, options, 1));
  changed = asset;
  changed.forms[0].signs[1] = -1;
  differs("orientation", tagOf(changed, options, 1));
  changed = tetrahedron();
  ControlMeshInput moved;
  moved.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
  moved.tets = {{0, 1, 2, 3}};
  changed.mesh = ControlMesh::build(std::move(moved));
  differs("vertex", tagOf(changed, options, 1));
  const auto with = [&](const char* what, const auto& change) {
    BakeOptions other;
    change(other);
    differs(what, tagOf(asset, other, 1));
  };
  with("half", [](BakeOptions& o) { o.half = true; });
  with("sampling", [](BakeOptions& o) { o.sampling = Sampling::Staggered; });
  with("target", [](BakeOptions& o) { o.target = "houdini"; });
  with("method", [](BakeOptions& o) { o.method = BakeMethod::Samples; });
  with("zeta", [](BakeOptions& o) { o.zeta += 0.5; });
  with("derivative", [](BakeOptions& o) { o.derivative = true; });
  with("wall surface", [](BakeOptions& o) { o.wallSurface = BoundaryRows::Loop; });
}

TEST(ContentTag, TellsNothingElse) {
  const ControlAsset asset = tetrahedron();
  const std::string tag = tagOf(asset, {}, 1);
  EXPECT_EQ(tag.size(), 36u);
  EXPECT_EQ(tag[14], '5');  // the version of UUID that is made from a name
  BakeOptions options;
  options.frames = {{1}};
  options.skipExisting = true;
  options.resolution = 10;  // the plan says how fine it is
  EXPECT_EQ(tagOf(asset, options, 1), tag);
  ControlAsset changed = asset;
  changed.forms[0].frames[2] = {7.0, 8.0};
  EXPECT_EQ(tagOf(changed, {}, 1), tag);
}

class Heads : public ::testing::Test {
 protected:
  Heads() : folder_(system::makeTemporaryFolder("octet-test-")) {
    options_.resolution = 12;
    report_ = bake(tetrahedron(), options_, folder_ / "a.##.vdb");
  }
  ~Heads() override { fs::remove_all(folder_); }

  const fs::path folder_;
  BakeOptions options_;
  BakeReport report_;
};

TEST_F(Heads, TellWholeFilesFromCutOnes) {
  const fs::path file = folder_ / "a.01.vdb";
  const auto head = readVdbHead(file);
  ASSERT_TRUE(head);
  std::string tag, name;
  for (const VdbMetadata& m : *head) {
    if (m.name == kContentMetadata) tag = std::get<std::string>(m.value);
    if (m.name == "octet_asset") name = std::get<std::string>(m.value);
  }
  EXPECT_EQ(tag.size(), 36u);
  EXPECT_EQ(name, "one");
  const auto size = fs::file_size(file);
  for (const auto cut : {size - 1, size / 2, std::uintmax_t{100}, std::uintmax_t{0}}) {
    fs::resize_file(file, cut);
    EXPECT_FALSE(readVdbHead(file)) << cut;
  }
  std::ofstream(file) << "no grid, but a text of some length, so that there is something to read";
  EXPECT_FALSE(readVdbHead(file));
  EXPECT_FALSE(readVdbHead(folder_ / "none.vdb"));
}

TEST_F(Heads, LetABakeSkipWhatIsThere) {
  const auto skipped = [&](const ControlAsset& asset) {
    BakeOptions again = options_;
    again.skipExisting = true;
    std::vector<bool> result;
    for (const BakedFile& file : bake(asset, again, folder_ / "a.##.vdb").files) {
      EXPECT_EQ(file.skipped, file.grids.empty());
      result.push_back(file.skipped);
    }
    return result;
  };
  EXPECT_EQ(skipped(tetrahedron()), std::vector<bool>({true, true}));
  fs::remove(folder_ / "a.02.vdb");
  EXPECT_EQ(skipped(tetrahedron()), std::vector<bool>({true, false}));
  fs::resize_file(folder_ / "a.01.vdb", fs::file_size(folder_ / "a.01.vdb") - 1);
  EXPECT_EQ(skipped(tetrahedron()), std::vector<bool>({false, true}));
  ControlAsset changed = tetrahedron();
  changed.forms[0].frames[2][0] = 5;
  EXPECT_EQ(skipped(changed), std::vector<bool>({true, false}));
  options_.half = true;
  EXPECT_EQ(skipped(changed), std::vector<bool>({false, false}));
}

}  // namespace
}  // namespace octet
