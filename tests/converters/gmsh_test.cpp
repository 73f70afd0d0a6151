// SPDX-License-Identifier: Apache-2.0
// Meshes through Gmsh: every format makes the same control asset, with data as forms and physical
// groups as creases and corners (tests/data/gmsh/make_data.py tells what the files hold).
#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include <octet/converters/gmsh/gmsh_import.h>
#include <octet/core/base/error.h>

#include "tests/support/test_data.h"

namespace octet {
namespace {

std::string dataFile(const std::string& name) { return testing::testData("gmsh/" + name); }

class EveryFormat : public ::testing::TestWithParam<const char*> {};

/// Nodes 3, 7, 10, 20 and 21 become vertices 0 to 4; node 99 belongs to no tetrahedron.
TEST_P(EveryFormat, HasTheSameMesh) {
  const ControlAsset asset = readGmshMesh(dataFile(GetParam()));
  EXPECT_EQ(asset.name, std::string(GetParam()).substr(0, std::string(GetParam()).find('.')));
  const Array<Vec3>& x = asset.mesh.positions();
  ASSERT_EQ(x.size(), 5u);
  EXPECT_EQ(x[0], Vec3(1, 0, 0));
  EXPECT_EQ(x[1], Vec3(0, 1, 0));
  EXPECT_EQ(x[2], Vec3(0, 0, 0));
  EXPECT_EQ(x[3], Vec3(0, 0, 1));
  EXPECT_EQ(x[4], Vec3(1, 1, 1));
  const Complex& c = *asset.mesh.complex();
  ASSERT_EQ(c.tetCount(), 2);
  EXPECT_EQ(c.octCount(), 0);
  EXPECT_DOUBLE_EQ(std::abs(cellVolume6(c, x, 0)), 1.0);
  EXPECT_DOUBLE_EQ(std::abs(cellVolume6(c, x, 1)), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Files, EveryFormat,
                         ::testing::Values("two_tets_22.msh", "two_tets_22_binary.msh",
                                           "two_tets_41.msh", "two_tets_41_binary.msh",
                                           "two_tets.mesh", "two_tets.vtk", "two_tets_binary.vtk"),
                         [](const auto& file) {
                           std::string name = file.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

class EveryMsh : public ::testing::TestWithParam<const char*> {
 protected:
  const ControlAsset asset_ = readGmshMesh(dataFile(GetParam()));

  template <int K>
  double at(const char* form, Index simplex, int frame = 0) const {
    return coefficients<K>(asset_, asset_.form(form), frame)[simplex];
  }
  Index edge(Index a, Index b) const { return asset_.mesh.edge(a, b).index(); }
  Index facet(Index a, Index b, Index c) const { return asset_.mesh.facet(a, b, c).index(); }
};

TEST_P(EveryMsh, DataBecomesForms) {
  ASSERT_EQ(asset_.forms.size(), 4u);
  for (const auto& [name, degree] :
       {std::pair{"pressure", 0}, {"potential", 1}, {"velocity", 2}, {"density", 3}}) {
    EXPECT_EQ(asset_.form(name).degree, degree);
  }
  // By node; that of node 99, which has none, is dropped.
  const double pressures[] = {2, 3, 1, 4, 5};
  for (Index v = 0; v < 5; ++v) EXPECT_EQ(at<0>("pressure", v), pressures[v]);
  EXPECT_EQ(at<3>("density", 0), 7);
  EXPECT_EQ(at<3>("density", 1), 8);
}

TEST_P(EveryMsh, NodesOrientLinesAndTriangles) {
  // Lines (10,3), (7,3), (20,21) against edges stored ascending.
  EXPECT_EQ(at<1>("potential", edge(0, 2)), -1.5);
  EXPECT_EQ(at<1>("potential", edge(0, 1)), 2);
  EXPECT_EQ(at<1>("potential", edge(3, 4)), 0.25);
  EXPECT_EQ(at<1>("potential", edge(0, 3)), 0);
  // Triangles (3,7,20), (10,7,3), (7,21,20).
  EXPECT_EQ(at<2>("velocity", facet(0, 1, 3), 1), 1);
  EXPECT_EQ(at<2>("velocity", facet(0, 1, 2), 1), -2);
  EXPECT_EQ(at<2>("velocity", facet(1, 3, 4), 1), -3);
}

TEST_P(EveryMsh, TimeStepsBecomeFrames) {
  EXPECT_EQ(asset_.frameRange(), (std::pair{1, 2}));
  EXPECT_FALSE(asset_.form("pressure").animated());
  EXPECT_EQ(at<2>("velocity", facet(0, 1, 3), 2), -1);
  EXPECT_EQ(at<2>("velocity", facet(0, 1, 2), 2), 2.5);
  EXPECT_EQ(at<2>("velocity", facet(1, 3, 4), 2), 0);  // not listed in this step
}

TEST_P(EveryMsh, PhysicalGroupsBecomeCreasesAndCorners) {
  const Complex& c = *asset_.mesh.complex();
  for (Index e = 0; e < c.edgeCount(); ++e) {
    const bool crease = e == edge(0, 2) || e == edge(3, 4);
    EXPECT_EQ((c.edgeFlags[e] & kOnCrease) != 0, crease) << e;
  }
  EXPECT_EQ(asset_.mesh.corners(), std::vector<Index>{4});
}

INSTANTIATE_TEST_SUITE_P(Files, EveryMsh,
                         ::testing::Values("two_tets_22.msh", "two_tets_22_binary.msh",
                                           "two_tets_41.msh", "two_tets_41_binary.msh"),
                         [](const auto& file) {
                           std::string name = file.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(Gmsh, ScriptsAreNotRun) {
  // Gmsh would run a .msh that is none, and a .opt beside any mesh.
  const std::string folder = ::testing::TempDir();
  const std::string mesh = folder + "script.msh", trace = folder + "trace";
  std::remove(trace.c_str());
  const std::string script = "SystemCall \"touch " + trace + "\";\n";
  std::ofstream(mesh) << script;
  EXPECT_THROW(readGmshMesh(mesh), InputError);
  std::ofstream(mesh) << std::ifstream(dataFile("two_tets_41.msh")).rdbuf();
  std::ofstream(mesh + ".opt") << script;
  EXPECT_EQ(readGmshMesh(mesh).forms.size(), 4u);
  EXPECT_FALSE(std::ifstream(trace)) << "a script was run";
}

TEST(Gmsh, SeveralThreadsMayRead) {
  std::vector<std::thread> threads;
  std::atomic<int> good{0};
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back(
        [&] { good += readGmshMesh(dataFile("two_tets_41_binary.msh")).forms.size() == 4; });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 4);
}

}  // namespace
}  // namespace octet
