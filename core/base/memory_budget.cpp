// SPDX-License-Identifier: Apache-2.0
#include "memory_budget.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <sys/resource.h>
#include <unistd.h>

namespace octet {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kKilo = 1024, kMega = 1024 * kKilo;

/// A number at the start of a text; nothing for "max" and other words.
std::optional<double> number(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(text->c_str(), &end);
  if (end == text->c_str() || !std::isfinite(value) || value < 0) return std::nullopt;
  return value;
}

/// The number after a word that begins a line.
std::optional<double> entry(const std::optional<std::string>& text, const std::string& word) {
  std::istringstream lines(text.value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, word.size(), word) == 0) return number(line.substr(word.size()));
  }
  return std::nullopt;
}

/// Where a version of control groups says what.
struct GroupFiles {
  const char *root, *limit, *usage, *reclaimable;
};
constexpr GroupFiles kVersion1{"/sys/fs/cgroup/memory", "/memory.limit_in_bytes",
                               "/memory.usage_in_bytes", "total_inactive_file "};
constexpr GroupFiles kVersion2{"/sys/fs/cgroup", "/memory.max", "/memory.current",
                               "inactive_file "};

/// What a group and those around it leave. Cached files count as used, but give way.
double leftInGroups(const MemoryFacts& facts, const GroupFiles& files, std::string group) {
  double least = kUnlimited;
  for (;;) {
    if (!group.empty() && group.back() == '/') group.pop_back();
    const std::string folder = files.root + group;
    if (const auto limit = number(facts.file(folder + files.limit))) {
      const double used = number(facts.file(folder + files.usage)).value_or(0);
      const double cached =
          entry(facts.file(folder + "/memory.stat"), files.reclaimable).value_or(0);
      least = std::min(least, std::max(0.0, *limit - std::max(0.0, used - cached)));
    }
    if (group.empty()) return least;
    group.resize(group.rfind('/') == std::string::npos ? 0 : group.rfind('/'));
  }
}

/// Lines of /proc/self/cgroup read "0::/group" and "4:cpu,memory:/group".
double leftInGroups(const MemoryFacts& facts) {
  double least = kUnlimited;
  std::istringstream lines(facts.file("/proc/self/cgroup").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string group = line.substr(second + 1);
    if (controllers == ",,") least = std::min(least, leftInGroups(facts, kVersion2, group));
    if (controllers.find(",memory,") != std::string::npos) {
      least = std::min(least, leftInGroups(facts, kVersion1, group));
    }
  }
  return least;
}

/// 0 stands for all of a node's memory.
double given(const MemoryFacts& facts, const char* name, double unit) {
  const double value = number(facts.environment(name)).value_or(0);
  return value > 0 ? value * unit : kUnlimited;
}

}  // namespace

std::string inGigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, bytes < 99.5e8 ? "%.1f GB" : "%.0f GB", bytes / 1e9);
  return text;
}

MemoryReservation::~MemoryReservation() {
  if (budget_) budget_->release(bytes_);
}

MemoryReservation MemoryBudget::reserve(double bytes, const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double left = std::max(0.0, limit_ - reserved_);
  if (!(bytes <= left)) {
    throw MemoryError(
        "", what + " need " + inGigabytes(bytes) + " of memory; " + inGigabytes(left) + " are left",
        bytes, left);
  }
  reserved_ += bytes;
  return {shared_from_this(), bytes};
}

double MemoryBudget::available() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::max(0.0, limit_ - reserved_);
}

void MemoryBudget::release(double bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  reserved_ -= bytes;
}

MemoryFacts MemoryFacts::ofProcess() {
  MemoryFacts facts;
  facts.file = [](const std::string& path) -> std::optional<std::string> {
    std::ifstream in(path);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf())) return std::nullopt;
    return text.str();
  };
  facts.environment = [](const std::string& name) -> std::optional<std::string> {
    const char* const value = std::getenv(name.c_str());
    return value ? std::optional<std::string>(value) : std::nullopt;
  };
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  if (size > 0) facts.pageSize = static_cast<double>(size);
  if (pages > 0) facts.physical = static_cast<double>(pages) * facts.pageSize;
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
    facts.addressSpace = static_cast<double>(space.rlim_cur);
  }
  return facts;
}

double memoryLimit(const MemoryFacts& facts) {
  const double available =
      kKilo * entry(facts.file("/proc/meminfo"), "MemAvailable:").value_or(facts.physical / kKilo);
  const double usedSpace = facts.pageSize * number(facts.file("/proc/self/statm")).value_or(0);
  return std::min({available, leftInGroups(facts), std::max(0.0, facts.addressSpace - usedSpace),
                   given(facts, "SLURM_MEM_PER_NODE", kMega), given(facts, "CUE_MEMORY", kKilo)});
}

}  // namespace octet
