// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/base/progress.h>

namespace octet::cli {

/// Progress with rate and time left on stderr, when that is a terminal; cancels on Ctrl-C.
ProgressCallback consoleProgress();

/// From now on Ctrl-C makes the next progress report cancel; a second one ends the program.
void watchForInterrupt();
bool interrupted();

/// Reads a control asset, or a mesh in a format that the Gmsh SDK knows.
ControlAsset readAsset(const std::string& path);

/// "1,234,567"
std::string grouped(std::int64_t n);

}  // namespace octet::cli
