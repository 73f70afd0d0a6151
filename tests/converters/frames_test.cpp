// SPDX-License-Identifier: Apache-2.0
// Frames as farms and programs write them: lists, and places in the names of files.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <octet/converters/io/frames.h>
#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

namespace octet {
namespace {

namespace fs = std::filesystem;
using List = std::vector<int>;

TEST(FrameList, ReadsWhatFarmsWrite) {
  EXPECT_EQ(parseFrames("7"), List({7}));
  EXPECT_EQ(parseFrames("1-4"), List({1, 2, 3, 4}));
  EXPECT_EQ(parseFrames("1-10x3"), List({1, 4, 7, 10}));
  EXPECT_EQ(parseFrames("1-9x3"), List({1, 4, 7}));
  EXPECT_EQ(parseFrames("1,3,7-9"), List({1, 3, 7, 8, 9}));
  EXPECT_EQ(parseFrames("-2-2"), List({-2, -1, 0, 1, 2}));
  EXPECT_EQ(parseFrames("-5--3"), List({-5, -4, -3}));
  EXPECT_EQ(parseFrames("-5"), List({-5}));
  EXPECT_EQ(parseFrames("0010-0012"), List({10, 11, 12}));
}

TEST(FrameList, KeepsTheOrderAndEachFrameOnce) {
  EXPECT_EQ(parseFrames("9,1-3,2-4"), List({9, 1, 2, 3, 4}));
}

TEST(FrameList, RefusesWhatIsNone) {
  for (const char* text : {"", ",", "1,", "one", "1-", "1-2-3", "1-10x", "1-10x0", "1-10x-1", "4-3",
                           " 1", "1 -2", "1:3", "1.5", "99999999999", "1-99999999", "--1"}) {
    EXPECT_THROW(parseFrames(text), InputError) << text;
  }
}

TEST(FrameList, IsWrittenAsItIsRead) {
  for (const char* text : {"7", "1-4", "1-9x2", "1,3", "1-3,7-9", "-5-5", "-7--1x2,4"}) {
    EXPECT_EQ(frameList(parseFrames(text)), text);
  }
  EXPECT_EQ(frameList({}), "");
}

TEST(FrameName, KnowsEveryPlace) {
  const struct {
    const char *name, *at7;
  } kCases[] = {{"a.####.vdb", "a.0007.vdb"},
                {"a.#.vdb", "a.7.vdb"},
                {"a_##_b.vdb", "a_07_b.vdb"},
                {"a.@@@@.vdb", "a.0007.vdb"},
                {"a.@.vdb", "a.7.vdb"},
                {"a.%04d.vdb", "a.0007.vdb"},
                {"a.%d.vdb", "a.7.vdb"},
                {"a%02d.vdb", "a07.vdb"},
                {"a.$F4.vdb", "a.0007.vdb"},
                {"a.$F.vdb", "a.7.vdb"},
                {"a.<frame>.vdb", "a.0007.vdb"},
                {"out/a.####.vdb", "out/a.0007.vdb"},
                {"/x/a.####.vdb", "/x/a.0007.vdb"}};
  for (const auto& [name, at7] : kCases) {
    const FrameName frames(name);
    EXPECT_TRUE(frames.hasFrame()) << name;
    EXPECT_EQ(frames.at(7), at7);
    EXPECT_EQ(frames.numbered().at(7), at7);
    EXPECT_EQ(frames.frameOf(fs::path(at7).filename()), 7) << name;
  }
}

TEST(FrameName, OfNoPlaceIsNumberedBeforeItsEnding) {
  const FrameName name("out/a.b.vdb");
  EXPECT_FALSE(name.hasFrame());
  EXPECT_EQ(name.at(3), "out/a.b.vdb");
  EXPECT_EQ(name.numbered().at(3), "out/a.b.0003.vdb");
  EXPECT_EQ(FrameName("a").numbered().at(3), "a.0003");
}

TEST(FrameName, CountsASignAsADigitAndTakesMoreDigitsWhereNeeded) {
  EXPECT_EQ(FrameName("a.####.vdb").at(-5), "a.-005.vdb");
  EXPECT_EQ(FrameName("a.%04d.vdb").at(-5), "a.-005.vdb");
  EXPECT_EQ(FrameName("a.##.vdb").at(12345), "a.12345.vdb");
  EXPECT_EQ(FrameName("a.####.vdb").frameOf("a.-005.vdb"), -5);
}

TEST(FrameName, DoesNotLookIntoFolders) {
  EXPECT_FALSE(FrameName("take@2/v##/a.vdb").hasFrame());
  EXPECT_EQ(FrameName("take@2/a.##.vdb").at(1), "take@2/a.01.vdb");
}

TEST(FrameName, TakesOtherSignsForWhatTheyAre) {
  for (const char* name : {"100%.vdb", "a$b.vdb", "a%s.vdb", "a<b>.vdb", "$HIP.vdb"}) {
    EXPECT_FALSE(FrameName(name).hasFrame()) << name;
  }
  EXPECT_THROW(FrameName("a.##.b.##.vdb"), InputError);
}

TEST(FrameName, FindsItsFiles) {
  const fs::path folder = system::makeTemporaryFolder("octet-test-");
  for (const char* name : {"a.0002.vdb", "a.0001.vdb", "a.-003.vdb", "a.2.vdb", "a.0001.vdb.bak",
                           "b.0001.vdb", "a.x.vdb", "a.12345.vdb"}) {
    std::ofstream(folder / name) << "x";
  }
  List frames;
  for (const auto& [frame, path] : FrameName(folder / "a.####.vdb").files()) {
    EXPECT_TRUE(fs::exists(path));
    frames.push_back(frame);
  }
  EXPECT_EQ(frames, List({-3, 1, 2, 12345}));
  EXPECT_THROW(FrameName(folder / "c.####.vdb").files(), InputError);
  EXPECT_THROW(FrameName(folder / "none/c.####.vdb").files(), InputError);
  fs::remove_all(folder);
}

TEST(OutputAt, TakesAFrameOnlyWhereThereIsOne) {
  EXPECT_EQ(outputAt("a.##.json", 3), "a.03.json");
  EXPECT_EQ(outputAt("a.json", 3), "a.json");
  EXPECT_EQ(outputAt("a.json", std::nullopt), "a.json");
  EXPECT_THROW(outputAt("a.##.json", std::nullopt), InputError);
}

}  // namespace
}  // namespace octet
