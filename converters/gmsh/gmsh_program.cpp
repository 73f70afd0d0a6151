// SPDX-License-Identifier: Apache-2.0
#include "gmsh_program.h"

#include <filesystem>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

#include "../io/run_program.h"

namespace octet::gmsh_import {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "octetvdb-gmsh";

/// From the Python package's folder, PREFIX/lib/pythonX.Y/site-packages/octetvdb.
constexpr const char* kFromPackageToBin = "../../../../bin";

std::string findProgram() {
  const std::string code = system::fileOfThisCode();
  if (!code.empty()) {
    const fs::path folder = fs::path(code).parent_path();
    for (const fs::path& place : {folder, folder / kFromPackageToBin}) {
      const std::string file = (place / kProgram).lexically_normal();
      if (system::isExecutable(file)) return file;
    }
  }
  const std::string file = system::findOnPath(kProgram);
  if (!file.empty()) return file;
  throw IoError(kProgram,
                "is not installed. It reads and makes meshes with Gmsh and CGAL, and is a program "
                "of its own as these are under the GPL: build it with -DOCTETVDB_WITH_GMSH=ON, and "
                "put it beside octetvdb or on the PATH");
}

/// One call of the program.
class Call {
 public:
  Call(const GmshWork& work, const Context& context)
      : work_(work), context_(context), report_(work.report), reader_(work.mostBytes) {}

  template <typename Answer>
  Answer run() {
    const std::string program = findProgram();
    RunLimits limits;
    limits.time = work_.time;
    limits.goOn = [this] {
      context_.report(report_);
      return true;
    };
    const RunResult result = runProgram(
        {program, "serve"}, message(work_.request, work_.content),
        [this](std::string_view bytes) { take(bytes); }, limits);
    if (result.stopped) throw Cancelled();
    if (!greeted_) {
      throw IoError(
          program, "cannot be run: it " + failureOf(result) + "; started by hand it may tell more");
    }
    if (!answered_) fail(failureOf(result));
    return reading([this] { return unpack<Answer>(answer_); });
  }

 private:
  static std::string failureOf(const RunResult& result) {
    return result.failure.empty() ? "ended early" : result.failure;
  }

  [[noreturn]] void fail(const std::string& how) const {
    throw InputError("", work_.who + " " + how + " " + work_.doing);
  }

  /// Damaged messages come from a damaged process, but for the first one.
  template <typename Read>
  auto reading(const Read& read) const {
    try {
      return read();
    } catch (const InputError& e) {
      if (greeted_) fail("failed");
      throw IoError(kProgram,
                    "does not belong to this octetvdb: its " + e.place() + " " + e.reason());
    }
  }

  void take(std::string_view bytes) {
    reader_.take(bytes);
    while (auto next = reading([this] { return reader_.next(); })) use(&*next);
  }

  void use(Message* next) {
    greeted_ = greeted_ || next->kind == MessageKind::Hello;
    if (next->kind == MessageKind::Answer) {
      answer_ = std::move(next->content);
      answered_ = true;
    } else if (next->kind == MessageKind::Progress) {
      const auto done = reading([&] { return unpack<WorkDone>(next->content); });
      report_.done = done.done;
      report_.total = done.total;
      context_.report(report_);
    } else if (next->kind == MessageKind::Failure) {
      const auto failure = reading([&] { return unpack<WorkFailure>(next->content); });
      if (failure.ofInput) throw InputError(failure.place, failure.reason);
      throw IoError(failure.place.empty() ? kProgram : failure.place, failure.reason);
    }
  }

  const GmshWork& work_;
  const Context& context_;
  ProgressReport report_;
  MessageReader reader_;
  std::string answer_;
  bool greeted_ = false, answered_ = false;
};

}  // namespace

template <typename Answer>
Answer askGmsh(const GmshWork& work, const Context& context) {
  return Call(work, context).run<Answer>();
}

template GmshMesh askGmsh(const GmshWork&, const Context&);
template TriangleSurface askGmsh(const GmshWork&, const Context&);
template RemeshedSurface askGmsh(const GmshWork&, const Context&);

}  // namespace octet::gmsh_import
