// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/base/context.h>

namespace octet::cli {

/// What a command's long calls are told: progress goes to stderr (progress.h); Ctrl-C stops them;
/// memory is what this process may use.
Context consoleContext();

/// From now on Ctrl-C, or the SIGTERM of a farm, stops the work that polls; a second one
/// ends the program.
void watchForInterrupt();
/// The signal that did; 0 when none.
int interruptSignal();

/// Reads a control asset, or a mesh in a format that the Gmsh SDK knows.
ControlAsset readAsset(const std::string& path);

/// Refuses, before work is put into it, an output that cannot be written.
void checkOutput(const std::string& input, const std::string& output);

/// The same for a file that holds all frames, or none: its name has no place for one.
void checkSingleOutput(const std::string& control, const std::string& output);

/// The name of the one file that a command writes for a frame, or for none.
std::string outputPath(const std::string& output, std::optional<int> frame);

/// Reads --frames. @throws InputError
std::vector<int> readFrames(const std::string& text);

/// Indented JSON; text that is not UTF-8, such as a file's name, is made so.
std::string text(const nlohmann::ordered_json& document);

/// "1,234,567"
std::string grouped(std::int64_t n);

/// "99.9 %", rounded down: only all is "100.0 %".
std::string percent(std::uint64_t part, std::uint64_t whole);

}  // namespace octet::cli
