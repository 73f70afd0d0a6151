// SPDX-License-Identifier: Apache-2.0
// Small tools of core/base.
#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include <octet/core/base/disjoint_sets.h>
#include <octet/core/base/suggestion.h>

namespace octet {
namespace {

TEST(Suggestion, FindsSlipsOfThePen) {
  const std::vector<std::string> names = {"velocity", "potential", "pressure", "vel"};
  for (const char* slip : {"velocty", "Velocity", "veloctiy", "velocityy", "elocity"}) {
    EXPECT_EQ(nearestName(slip, names), "velocity") << slip;
  }
  EXPECT_EQ(nearestName("potental", names), "potential");
  for (const char* other : {"vorticity", "uv", "x", "", "mass", "density"}) {
    EXPECT_EQ(nearestName(other, names), "") << other;
  }
  EXPECT_EQ(didYouMean("velocty", names), "; did you mean \"velocity\"?");
  EXPECT_EQ(didYouMean("mass", names), "");
  EXPECT_EQ(listOf({"a", "b"}), "a, b");
}

TEST(DisjointSets, NumbersStartAlone) {
  DisjointSets sets(4);
  EXPECT_EQ(sets.count(), 4);
  for (Index k = 0; k < 4; ++k) EXPECT_EQ(sets.find(k), k);
  EXPECT_EQ(DisjointSets(0).count(), 0);
}

TEST(DisjointSets, JoiningSaysWhetherSetsWereApart) {
  DisjointSets sets(5);
  EXPECT_TRUE(sets.join(0, 1));
  EXPECT_TRUE(sets.join(2, 3));
  EXPECT_FALSE(sets.join(1, 0));
  EXPECT_FALSE(sets.join(4, 4));
  EXPECT_TRUE(sets.join(3, 0));
  EXPECT_FALSE(sets.join(1, 2));
  EXPECT_EQ(sets.count(), 2);
  EXPECT_EQ(sets.find(1), sets.find(2));
  EXPECT_NE(sets.find(1), sets.find(4));
}

TEST(DisjointSets, FindOneNumberPerSetHoweverTheyWereJoined) {
  constexpr Index kNumbers = 200;
  std::mt19937 random(5);
  DisjointSets sets(kNumbers);
  std::vector<int> labels(kNumbers);  // the same sets, by renaming all of one
  std::iota(labels.begin(), labels.end(), 0);
  for (int step = 0; step < 150; ++step) {
    const Index a = static_cast<Index>(random() % kNumbers);
    const Index b = static_cast<Index>(random() % kNumbers);
    const int from = labels[a], to = labels[b];
    EXPECT_EQ(sets.join(a, b), from != to);
    std::replace(labels.begin(), labels.end(), from, to);
  }
  std::map<int, Index> rootOf;
  for (Index k = 0; k < kNumbers; ++k) {
    EXPECT_EQ(rootOf.emplace(labels[k], sets.find(k)).first->second, sets.find(k));
    EXPECT_EQ(labels[sets.find(k)], labels[k]);
  }
  EXPECT_EQ(sets.count(), static_cast<Index>(rootOf.size()));
}

TEST(DisjointSets, ALongChainHasOneRoot) {
  constexpr Index kNumbers = 100000;
  DisjointSets sets(kNumbers);
  for (Index k = kNumbers - 1; k > 0; --k) EXPECT_TRUE(sets.join(k - 1, k));
  EXPECT_EQ(sets.count(), 1);
  EXPECT_EQ(sets.find(0), sets.find(kNumbers - 1));
}

}  // namespace
}  // namespace octet
