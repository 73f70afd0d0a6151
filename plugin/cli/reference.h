// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace octet::cli {

/// Adds --reference, which no help shows: prints the command's man page, its completion for bash or
/// its page in Markdown, all made from the options that the program has.
void addReference(CLI::App* program);

}  // namespace octet::cli
