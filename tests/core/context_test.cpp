// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <octet/core/base/context.h>
#include <octet/core/base/reported_loop.h>

namespace octet {
namespace {

/// A context that keeps what it is told.
struct Listener {
  std::vector<ProgressReport> heard;
  Context context{[this](const ProgressReport& report) {
    heard.push_back(report);
    return true;
  }};
};

TEST(Context, WithoutPartsNeverStopsAndHasNoLimit) {
  const Context context;
  EXPECT_FALSE(context);
  context.stop();
  context.poll();
  context.report({"stage", 1, 2, "things"});
  EXPECT_EQ(context.reserve(1e30, "dreams").bytes(), 0);
  EXPECT_FALSE(Context(ProgressCallback()));
}

TEST(Context, PartsMakeOneFractionThatNeverFalls) {
  Listener listener;
  const auto work = [](const Context& context) {
    for (std::size_t k = 0; k <= 4; ++k) context.report({"work", k, 4, "steps"});
  };
  work(listener.context.sub(0.3));
  {
    const Context middle = listener.context.sub(0.5);
    work(middle.sub(0.5));
    work(middle.sub(0.5));
  }
  work(listener.context);  // all that is left
  ASSERT_EQ(listener.heard.size(), 20u);
  const double expected[] = {0,    0.075,  0.15,  0.225,  0.3, 0.3, 0.3625, 0.425, 0.4875, 0.55,
                             0.55, 0.6125, 0.675, 0.7375, 0.8, 0.8, 0.85,   0.9,   0.95,   1};
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_NEAR(listener.heard[k].fraction, expected[k], 1e-12) << k;
    EXPECT_EQ(listener.heard[k].done, k % 5);
    EXPECT_EQ(listener.heard[k].total, 4u);
    EXPECT_EQ(listener.heard[k].stage, "work");
  }
  work(listener.context);  // stages after one another in one part
  EXPECT_EQ(listener.heard.back().fraction, 1);
  for (std::size_t k = 1; k < listener.heard.size(); ++k) {
    EXPECT_GE(listener.heard[k].fraction, listener.heard[k - 1].fraction) << k;
  }
}

TEST(Context, SharesBeyondTheWholeEndWithIt) {
  Listener listener;
  listener.context.sub(0.8).report({"a", 1, 1, ""});
  listener.context.sub(0.8).report({"b", 1, 1, ""});
  EXPECT_EQ(listener.heard.back().fraction, 1);
  listener.context.sub(0.8).report({"c", 1, 1, ""});
  EXPECT_EQ(listener.heard.back().fraction, 1);
}

TEST(Context, StopsForCallbackForAskersAndForGood) {
  const Context refusing([](const ProgressReport&) { return false; });
  EXPECT_NO_THROW(refusing.poll());
  EXPECT_THROW(refusing.report({"stage"}), Cancelled);
  EXPECT_THROW(refusing.sub(0.1).poll(), Cancelled);

  Listener listener;
  const Context copy = listener.context;
  std::thread([copy] { copy.stop(); }).join();
  EXPECT_THROW(listener.context.poll(), Cancelled);
  EXPECT_THROW(listener.context.report({"stage"}), Cancelled);
  EXPECT_TRUE(listener.heard.empty());

  bool asked = false;
  ContextParts parts;
  parts.stop = [&] { return asked; };
  const Context flag(parts);
  EXPECT_NO_THROW(flag.poll());
  asked = true;
  EXPECT_THROW(flag.poll(), Cancelled);
}

TEST(Context, PollLetsTheCallbackSpeakInItsOwnThreadOnly) {
  const std::thread::id mine = std::this_thread::get_id();
  std::size_t spoken = 0;
  bool strange = false;
  const Context context([&](const ProgressReport& report) {
    spoken += report.stage == "long step" ? 1 : 0;
    strange |= std::this_thread::get_id() != mine;
    return spoken < 3;
  });
  context.report({"long step", 0, 1, ""});
  const auto begin = std::chrono::steady_clock::now();
  const auto pollFor = [&](int seconds) {
    while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(seconds)) context.poll();
  };
  EXPECT_THROW(pollFor(20), Cancelled);
  EXPECT_EQ(spoken, 3u);
  EXPECT_FALSE(strange);
}

TEST(Context, CallbackMayWorkItself) {
  int depth = 0, deepest = 0;
  Context* itself = nullptr;
  const Context context([&](const ProgressReport&) {
    deepest = std::max(deepest, ++depth);
    itself->poll();
    itself->report({"inner"});
    --depth;
    return true;
  });
  Context copy = context;
  itself = &copy;
  context.report({"outer"});
  EXPECT_EQ(deepest, 1);
}

TEST(Context, LoopsStopInAllThreads) {
  constexpr int kCount = 1 << 22;
  for (const bool reported : {false, true}) {
    std::atomic<int> done{0};
    bool asked = false;
    ContextParts parts;
    parts.stop = [&] { return __atomic_load_n(&asked, __ATOMIC_RELAXED); };
    const Context context(parts);
    const auto body = [&](int) {
      if (++done == 5000) __atomic_store_n(&asked, true, __ATOMIC_RELAXED);
    };
    EXPECT_THROW(reported ? reportedFor<int>(kCount, body, context, "count", "numbers", 256)
                          : parallelFor<int>(kCount, body, context, 256),
                 Cancelled);
    EXPECT_LT(done, 5000 + 256 * 256);  // every thread ends its piece
  }
}

TEST(Context, LoopsPassOnWhatACallbackThrows) {
  struct Mine {};
  int calls = 0;
  const Context context([&](const ProgressReport&) -> bool {
    if (++calls == 3) throw Mine();
    return true;
  });
  std::atomic<int> done{0};
  EXPECT_THROW(reportedFor<int>(
                   1 << 22, [&](int) { ++done; }, context, "count", "numbers", 256),
               Mine);
  EXPECT_LT(done, 1 << 22);
}

TEST(Context, LoopsDoEverythingOnce) {
  Listener listener;
  std::vector<int> times(300'000);
  reportedFor<std::size_t>(
      times.size(), [&](std::size_t k) { ++times[k]; }, listener.context, "count", "numbers", 100);
  parallelFor<std::size_t>(
      times.size(), [&](std::size_t k) { ++times[k]; }, listener.context, 7);
  EXPECT_EQ(times, std::vector<int>(times.size(), 2));
  EXPECT_EQ(listener.heard.front().done, 0u);
  EXPECT_EQ(listener.heard.back().done, times.size());
  EXPECT_EQ(listener.heard.back().fraction, 1);
}

TEST(Memory, IsRefusedBeforeAndGivenBackAfter) {
  ContextParts parts;
  parts.memoryLimit = 1000;
  const Context context(parts);
  {
    const MemoryReservation some = context.reserve(600, "some numbers");
    EXPECT_EQ(some.bytes(), 600);
    try {
      context.sub(0.5).reserve(500, "more numbers");
      ADD_FAILURE() << "was not refused";
    } catch (const MemoryError& e) {
      EXPECT_EQ(e.needed(), 500);
      EXPECT_EQ(e.available(), 400);
      EXPECT_EQ(e.reason().find("more numbers need "), 0u) << e.reason();
    }
    MemoryReservation rest = context.reserve(400, "the rest");
    const MemoryReservation moved = std::move(rest);
    EXPECT_THROW(context.reserve(1, "one byte"), MemoryError);
  }
  EXPECT_NO_THROW(context.reserve(1000, "everything"));
  EXPECT_THROW(context.reserve(std::numeric_limits<double>::quiet_NaN(), "nothing"), MemoryError);
}

/// Facts from a table of files and environment variables.
MemoryFacts facts(std::map<std::string, std::string> texts) {
  const auto find = [texts =
                         std::move(texts)](const std::string& name) -> std::optional<std::string> {
    const auto at = texts.find(name);
    return at == texts.end() ? std::nullopt : std::optional<std::string>(at->second);
  };
  MemoryFacts result;
  result.file = result.environment = find;
  return result;
}

constexpr double kMega = 1024 * 1024;
const std::pair<const std::string, std::string> kMachine{
    "/proc/meminfo", "MemTotal:       16384000 kB\nMemAvailable:    8192000 kB\nCached: 1 kB\n"};

TEST(MemoryLimit, IsWhatTheMachineHasLeft) {
  EXPECT_EQ(memoryLimit(facts({kMachine})), 8000 * kMega);
  MemoryFacts bare = facts({});
  EXPECT_EQ(memoryLimit(bare), HUGE_VAL);
  bare.physical = 100;
  EXPECT_EQ(memoryLimit(bare), 100);
}

TEST(MemoryLimit, FollowsControlGroupsOfVersion2) {
  const std::string root = "/sys/fs/cgroup";
  std::map<std::string, std::string> texts = {
      kMachine,
      {"/proc/self/cgroup", "0::/farm/job\n"},
      {root + "/farm/job/memory.max", "max\n"},
      {root + "/farm/memory.max", "1048576000\n"},
      {root + "/farm/memory.current", "524288000\n"},
      {root + "/farm/memory.stat", "anon 1\ninactive_file 104857600\nactive_file 7\n"}};
  EXPECT_EQ(memoryLimit(facts(texts)), 600 * kMega);
  texts[root + "/farm/job/memory.max"] = "104857600\n";
  EXPECT_EQ(memoryLimit(facts(texts)), 100 * kMega);
  texts[root + "/farm/job/memory.current"] = "204857600\n";
  EXPECT_EQ(memoryLimit(facts(texts)), 0);
  // In a container the group's own folder is the root.
  EXPECT_EQ(
      memoryLimit(facts(
          {kMachine, {"/proc/self/cgroup", "0::/\n"}, {root + "/memory.max", "104857600\n"}})),
      100 * kMega);
}

TEST(MemoryLimit, FollowsControlGroupsOfVersion1) {
  const std::string root = "/sys/fs/cgroup/memory";
  EXPECT_EQ(memoryLimit(facts({kMachine,
                               {"/proc/self/cgroup", "5:cpu,cpuacct:/a\n4:memory:/job\n1:x=y:/\n"},
                               {root + "/memory.limit_in_bytes", "9223372036854771712\n"},
                               {root + "/job/memory.limit_in_bytes", "209715200\n"},
                               {root + "/job/memory.usage_in_bytes", "104857600\n"},
                               {root + "/job/memory.stat", "total_inactive_file 52428800\n"}})),
            150 * kMega);
}

TEST(MemoryLimit, FollowsFarms) {
  EXPECT_EQ(memoryLimit(facts({kMachine, {"SLURM_MEM_PER_NODE", "4000"}})), 4000 * kMega);
  EXPECT_EQ(memoryLimit(facts({kMachine, {"SLURM_MEM_PER_NODE", "0"}})), 8000 * kMega);
  EXPECT_EQ(memoryLimit(facts({kMachine, {"CUE_MEMORY", "2048000"}})), 2000 * kMega);
  EXPECT_EQ(memoryLimit(facts({kMachine, {"CUE_MEMORY", "much"}})), 8000 * kMega);
  EXPECT_EQ(
      memoryLimit(facts({kMachine, {"CUE_MEMORY", "2048000"}, {"SLURM_MEM_PER_NODE", "1000"}})),
      1000 * kMega);
}

TEST(MemoryLimit, FollowsTheAddressSpace) {
  MemoryFacts limited = facts({kMachine, {"/proc/self/statm", "1000 500 1 1 1 1 1\n"}});
  limited.addressSpace = 5000 * 4096;
  EXPECT_EQ(memoryLimit(limited), 4000 * 4096);
  limited.addressSpace = 4096;
  EXPECT_EQ(memoryLimit(limited), 0);
}

TEST(MemoryLimit, OfThisProcessIsSomething) {
  EXPECT_GT(memoryLimit(), 0);
  EXPECT_LT(memoryLimit(), HUGE_VAL);
}

}  // namespace
}  // namespace octet
