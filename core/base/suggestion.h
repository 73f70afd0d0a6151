// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace octet {

/// Finds the name that was probably meant by one that there is not: the nearest, when few letters
/// of it differ; else an empty name.
std::string nearestName(const std::string& wanted, const std::vector<std::string>& names);

/// Ends a message about a name that there is not: "; did you mean \"velocity\"?", or nothing.
std::string didYouMean(const std::string& wanted, const std::vector<std::string>& names);

/// Lists names for a message: "a, b, c".
std::string listOf(const std::vector<std::string>& names);

}  // namespace octet
