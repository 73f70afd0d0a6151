// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

/// @file
/// The subcommands of octetvdb: each adds itself to the program and runs when it was chosen.

namespace octet::cli {

void addBake(CLI::App* program);
void addInfo(CLI::App* program);
void addRefine(CLI::App* program);

}  // namespace octet::cli
