// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace octet {

/// Calls `visit(line, number)` for the lines of a text file, counted from 1, without line ends.
/// @throws InputError when it cannot be read
void visitLines(const std::string& path, const std::function<void(std::string_view, int)>& visit);

/// Without blanks at either end.
std::string_view trimmed(std::string_view text);

/// Parts between any of the separators; runs of blanks count as one when `separators` is " \t".
std::vector<std::string_view> splitText(std::string_view text, std::string_view separators);

/// A number that takes up all of `text`, finite or not.
/// @throws InputError(file, place, ...)
double parseNumber(std::string_view text, const std::string& file, const std::string& place);

}  // namespace octet
