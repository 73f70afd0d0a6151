// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include <octet/core/base/context.h>

#include "messages.h"

namespace octet::gmsh_import {

/// What any work may take, beside what grows with its size.
inline constexpr std::uint64_t kLeastMemory = std::uint64_t{1} << 30;
inline constexpr std::chrono::milliseconds kLeastTime{60000};

/// Work that octetvdb-gmsh is asked to do.
struct GmshWork {
  MessageKind request;
  std::string content;
  /// Who works at what, for errors: "Gmsh" "failed" "meshing it".
  std::string who, doing;
  std::uint64_t mostBytes = UINT64_MAX;  ///< of the answer
  std::chrono::milliseconds time = std::chrono::hours(24);
  /// Is reported at once, several times a second, and with what the program says is done.
  ProgressReport report;
};

/// @brief Has octetvdb-gmsh, a program that uses Gmsh and CGAL and is under the GPL for it, do some
/// work. It runs beside this process, which it cannot harm, and ends with this call.
///
/// It is looked for beside the file that holds this code (the command or the Python module), in the
/// bin folder of the prefix that has this code as a Python module, and on PATH.
/// @return its answer: GmshMesh, TriangleSurface or RemeshedSurface
/// @throws InputError as the program says, and when it crashed or took too long; IoError when it is
/// not found or cannot be run; Cancelled within 0.2 s when the context says so
template <typename Answer>
Answer askGmsh(const GmshWork& work, const Context& context = {});

}  // namespace octet::gmsh_import
