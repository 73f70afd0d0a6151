// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "error.h"

namespace octet {

/// Work needs more memory than there is; said before any of it is allocated.
class MemoryError : public Error {
 public:
  /// @param needed, available  bytes
  MemoryError(std::string place, std::string reason, double needed, double available)
      : Error("", std::move(place), std::move(reason)), needed_(needed), available_(available) {}

  double needed() const { return needed_; }
  double available() const { return available_; }

 private:
  double needed_, available_;
};

/// "1.5 GB"
std::string inGigabytes(double bytes);

class MemoryBudget;

/// Keeps a part of a budget for as long as it lives; may be moved, not copied.
class MemoryReservation {
 public:
  MemoryReservation() = default;
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, double bytes)
      : budget_(std::move(budget)), bytes_(bytes) {}
  MemoryReservation(MemoryReservation&& other) noexcept { *this = std::move(other); }
  MemoryReservation& operator=(MemoryReservation&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MemoryReservation();

  double bytes() const { return bytes_; }

 private:
  std::shared_ptr<MemoryBudget> budget_;
  double bytes_ = 0;
};

/// @brief Counts what work is about to allocate against a limit. It allocates nothing and measures
/// nothing: whoever makes something large says so first. Thread safe.
class MemoryBudget : public std::enable_shared_from_this<MemoryBudget> {
 public:
  explicit MemoryBudget(double limit) : limit_(limit) {}

  /// @param what  what needs the bytes, in the plural: "20 million cells"
  /// @throws MemoryError when fewer are left
  MemoryReservation reserve(double bytes, const std::string& what);
  double available() const;

 private:
  friend class MemoryReservation;
  void release(double bytes);

  const double limit_;
  mutable std::mutex mutex_;
  double reserved_ = 0;
};

/// What is known of the memory that this process may use. Tests put their own in.
struct MemoryFacts {
  /// A file's text, nothing when it cannot be read.
  std::function<std::optional<std::string>(const std::string& path)> file;
  /// An environment variable, nothing when it is not set.
  std::function<std::optional<std::string>(const std::string& name)> environment;
  double physical = std::numeric_limits<double>::infinity();      ///< bytes of the machine
  double addressSpace = std::numeric_limits<double>::infinity();  ///< bytes, RLIMIT_AS
  double pageSize = 4096;                                         ///< bytes

  /// Those of this process.
  static MemoryFacts ofProcess();
};

/// Finds how many bytes this process may still allocate: the least of the memory available on the
/// machine, the limits of its control groups (version 1 and 2, and of the groups around them) less
/// what they use, its limit of address space less what it uses, and what a farm has given it:
/// SLURM_MEM_PER_NODE, in MB, and OpenCue's CUE_MEMORY, in KB. What is not known does not limit.
double memoryLimit(const MemoryFacts& facts = MemoryFacts::ofProcess());

}  // namespace octet
