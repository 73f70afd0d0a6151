// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>

#include "error.h"
#include "memory_budget.h"

namespace octet {

/// What long work reports while it runs: the stage's name and how much of it is done.
struct ProgressReport {
  std::string stage;      ///< "refine level 3", "bake velocity", ...; empty before the first
  std::size_t done = 0;   ///< units finished, 0 <= done <= total
  std::size_t total = 0;  ///< units in this stage; 0 when that is not known
  const char* unit = "";  ///< what is counted: "cells", "leaves", ...
  /// How much of the whole call is done, 0 to 1; it never falls. Set by the context.
  double fraction = 0;
};

/// Called between pieces of work, always from the thread that made the context; return false to
/// cancel.
using ProgressCallback = std::function<bool(const ProgressReport&)>;

/// What a context is made of; each part may be missing.
struct ContextParts {
  ProgressCallback progress{};
  /// Asked whether to stop, from any thread and often: it does no more than look at a flag.
  std::function<bool()> stop{};
  double memoryLimit = std::numeric_limits<double>::infinity();  ///< bytes
};

/// @brief What long work is told by whoever calls it: to whom it reports, when it stops, how much
/// memory it may take. Passed as the last parameter to every long call; copies are cheap and stand
/// for the same call. Nobody keeps one when the call is over.
///
/// Work reports from the thread that made the context, its other threads only poll. A context
/// without parts never stops and costs nothing.
class Context {
 public:
  Context() = default;
  explicit Context(ContextParts parts);
  /// Reports to a ProgressCallback, or to what converts to one.
  template <typename Callback, typename = std::enable_if_t<
                                   std::is_invocable_r_v<bool, Callback&, const ProgressReport&>>>
  Context(Callback progress) : Context(ContextParts{std::move(progress), {}}) {}

  /// Tells the callback, with the fraction of the whole that this context's part makes of it.
  /// @throws Cancelled when the callback, or anybody else, asks to stop
  void report(ProgressReport report) const;
  /// Ends the work when somebody has asked to stop. In the thread that made the context it also
  /// repeats the last report, some times a second, so that the callback can ask. Any thread may
  /// call it. @throws Cancelled
  void poll() const;
  /// Asks the work to stop; any thread may. It stays asked.
  void stop() const;

  /// The next `share`, of 1, of what this context has to report: what is done within that, 0 to 1,
  /// moves the whole by so much. From the thread that made the context.
  Context sub(double share) const;

  /// Takes memory from the budget before it is allocated.
  /// @param what  what needs the bytes, in the plural: "20 million cells"
  /// @throws MemoryError when the budget does not have that many bytes
  MemoryReservation reserve(double bytes, const std::string& what) const;

  /// Has it parts at all?
  explicit operator bool() const { return call_ != nullptr; }

 private:
  struct Call;
  struct Part;
  std::shared_ptr<Call> call_;
  std::shared_ptr<Part> part_;
};

}  // namespace octet
