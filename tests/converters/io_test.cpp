// SPDX-License-Identifier: Apache-2.0
// Files that appear whole or not at all, and programs run beside this one: whatever these do, this
// process goes on and nothing is left behind.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include <octet/converters/io/atomic_file.h>
#include <octet/converters/io/run_program.h>
#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

namespace octet {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

std::string contentOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A folder that is empty at first and gone at the end.
class AtomicFiles : public ::testing::Test {
 protected:
  AtomicFiles() : folder_(system::makeTemporaryFolder("octet-test-")) {}
  ~AtomicFiles() override { fs::remove_all(folder_); }

  std::size_t fileCount() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  const fs::path folder_;
  const fs::path path_ = folder_ / "out.vdb";
};

TEST_F(AtomicFiles, AppearWithTheCommit) {
  std::ofstream(path_) << "old";
  AtomicFile file(path_);
  EXPECT_EQ(fs::path(file.temporaryPath()).parent_path(), folder_);
  EXPECT_EQ(fs::path(file.temporaryPath()).extension(), ".vdb");
  std::ofstream(file.temporaryPath()) << "new";
  EXPECT_EQ(contentOf(path_), "old");
  file.commit();
  EXPECT_EQ(contentOf(path_), "new");
  EXPECT_EQ(fileCount(), 1u);
}

TEST_F(AtomicFiles, LeaveNothingWithoutOne) {
  std::ofstream(path_) << "old";
  {
    const AtomicFile file(path_);
    std::ofstream(file.temporaryPath()) << "half";
  }
  EXPECT_EQ(contentOf(path_), "old");
  EXPECT_EQ(fileCount(), 1u);
}

TEST_F(AtomicFiles, OfTheSameNameDoNotShareTheirTemporaries) {
  AtomicFile first(path_), second(path_);
  EXPECT_NE(first.temporaryPath(), second.temporaryPath());
  std::ofstream(first.temporaryPath()) << "first";
  std::ofstream(second.temporaryPath()) << "second";
  second.commit();
  first.commit();
  EXPECT_EQ(contentOf(path_), "first");
  EXPECT_EQ(fileCount(), 1u);
}

TEST_F(AtomicFiles, AreRefusedWhereNoneCanBe) {
  EXPECT_THROW(AtomicFile(folder_.string()), IoError);
  EXPECT_THROW(AtomicFile(folder_.string() + "/"), IoError);
  EXPECT_THROW(AtomicFile(folder_ / "absent" / "out.vdb"), IoError);
  EXPECT_THROW(AtomicFile("/dev/null"), IoError);
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(AtomicFiles, TellWhenTheyCannotBeCommitted) {
  std::ofstream(path_) << "old";
  AtomicFile file(path_);
  fs::remove(file.temporaryPath());
  EXPECT_THROW(file.commit(), IoError);
  EXPECT_EQ(contentOf(path_), "old");
}

// ---- programs -----------------------------------------------------------------------------------

struct Ran {
  RunResult result;
  std::string output;
  milliseconds took;
};

/// Runs a script of the shell.
Ran ran(const std::string& script, const std::string& input = "", const RunLimits& limits = {}) {
  Ran ran;
  const auto start = std::chrono::steady_clock::now();
  ran.result = runProgram(
      {"/bin/sh", "-c", script}, input, [&](std::string_view bytes) { ran.output += bytes; },
      limits);
  ran.took = std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - start);
  return ran;
}

/// Text that no pipe holds at once.
std::string longText() {
  std::string text;
  for (int k = 0; k < 1'000'000; ++k) text += std::to_string(k) + "\n";
  return text;
}

TEST(RunProgram, CarriesAllBytesBothWays) {
  const std::string text = longText();
  const Ran cat = ran("cat", text);
  EXPECT_EQ(cat.result.failure, "");
  EXPECT_TRUE(cat.output == text);
  EXPECT_EQ(ran("cat").output, "") << "an input that is empty ends";
  EXPECT_EQ(runProgram({"/bin/echo", "a b", "$c"}, "",
                       [](std::string_view bytes) {
                         if (!bytes.empty()) {
                           EXPECT_EQ(bytes, "a b $c\n");
                         }
                       },
                       {})
                .failure,
            "");
}

TEST(RunProgram, TakesHugeOutput) {
  const Ran all = ran("head -c 100000000 /dev/zero");
  EXPECT_EQ(all.result.failure, "");
  EXPECT_EQ(all.output.size(), 100'000'000u);
}

TEST(RunProgram, TellsOfCrashesAndEarlyEnds) {
  EXPECT_EQ(ran("kill -SEGV $$").result.failure, "crashed (signal 11)");
  const Ran early = ran("echo before; exit 3", longText());
  EXPECT_EQ(early.result.failure, "ended early (exit status 3)");
  EXPECT_EQ(early.output, "before\n");
  EXPECT_FALSE(early.result.stopped);
}

TEST(RunProgram, MayCloseItsInput) {
  const Ran closed = ran("exec <&-; sleep 0.1; echo done", longText());
  EXPECT_EQ(closed.result.failure, "");
  EXPECT_EQ(closed.output, "done\n");
}

TEST(RunProgram, MustEndSoonAfterItsOutput) {
  EXPECT_EQ(ran("exec >&-; sleep 60").result.failure, "did not end");
  EXPECT_EQ(ran("exec >&-; sleep 0.1").result.failure, "");
}

TEST(RunProgram, EndsInTime) {
  RunLimits limits;
  limits.time = milliseconds(200);
  for (const char* script : {"sleep 60", "while :; do :; done", "cat /dev/zero"}) {
    const Ran late = ran(script, longText(), limits);
    EXPECT_NE(late.result.failure.find("did not finish"), std::string::npos) << script;
    EXPECT_LT(late.took.count(), 2000) << script;
  }
}

TEST(RunProgram, IsEndedWhenAsked) {
  const auto start = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point asked;
  RunLimits limits;
  limits.goOn = [&] {
    asked = std::chrono::steady_clock::now();
    return asked < start + milliseconds(300);
  };
  const Ran stopped = ran("sleep 60", "", limits);
  EXPECT_TRUE(stopped.result.stopped);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, milliseconds(200));
  EXPECT_LT(stopped.took.count(), 300 + 200);
}

TEST(RunProgram, IsNotLeftWhenACallbackThrows) {
  const std::string folder = system::makeTemporaryFolder("octet-test-");
  // It would leave a trace a while later.
  const std::string script = "echo; sleep 0.5; touch " + folder + "/trace";
  RunLimits limits;
  limits.goOn = []() -> bool { throw std::logic_error("go on"); };
  EXPECT_THROW(ran(script, "", limits), std::logic_error);
  EXPECT_THROW(runProgram({"/bin/sh", "-c", script}, "",
                          [](std::string_view bytes) {
                            if (!bytes.empty()) throw std::logic_error("take");
                          },
                          {}),
               std::logic_error);
  std::this_thread::sleep_for(milliseconds(800));
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
}

TEST(RunProgram, HasNoFileOfOursAndNoSignalBlocked) {
  const std::ifstream open("/dev/null");
  // The shell's own listing is one.
  EXPECT_EQ(ran("ls /proc/self/fd").output, "0\n1\n2\n3\n");
  EXPECT_EQ(ran("grep SigBlk /proc/self/status").output, "SigBlk:\t0000000000000000\n");
}

TEST(RunProgram, CannotBeWhatIsNone) {
  EXPECT_THROW(runProgram({"/absent"}, "", [](std::string_view) {}, {}), IoError);
  EXPECT_THROW(runProgram({"/etc/passwd"}, "", [](std::string_view) {}, {}), IoError);
}

TEST(RunProgram, RunsFromSeveralThreads) {
  std::vector<std::thread> threads;
  std::vector<std::string> outputs(8);
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    threads.emplace_back([&, k] { outputs[k] = ran("cat", std::to_string(k)).output; });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t k = 0; k < outputs.size(); ++k) EXPECT_EQ(outputs[k], std::to_string(k));
}

TEST(System, KnowsItsOwnFile) {
  EXPECT_EQ(fs::path(system::fileOfThisCode()).filename(), "io_test");
  EXPECT_EQ(fs::path(system::findOnPath("sh")).filename(), "sh");
  EXPECT_EQ(system::findOnPath("no program has this name"), "");
}

}  // namespace
}  // namespace octet
