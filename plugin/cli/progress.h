// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <octet/core/base/context.h>

namespace octet::cli {

/// How progress is told, on stderr.
enum class ProgressStyle {
  Auto,    ///< a bar on a terminal, else plain lines, and none in the first second
  Bar,     ///< one line, overwritten
  Plain,   ///< a line each 10 % or 10 s
  OpenJd,  ///< Open Job Description's openjd_progress and openjd_status
  Alfred,  ///< ALF_PROGRESS, as Tractor and its like read it
  Json,    ///< an object a line
  None
};

/// The names of --progress.
const std::vector<std::pair<std::string, ProgressStyle>>& progressStyles();

/// Chooses for the whole process; Auto unless chosen.
void setProgress(ProgressStyle style);
ProgressStyle progressStyle();

/// Who is told of the work of a command; null for nobody.
ProgressCallback progressCallback();

/// Wipes the bar, when there is one, before something else is printed.
void clearProgress();
/// Says that all is done, to those that count on it.
void finishProgress();

}  // namespace octet::cli
