// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace octet {

/// Names and versions of the libraries that pictures need besides (converters/versions.h).
std::vector<std::pair<std::string, std::string>> pictureLibraryVersions();

}  // namespace octet
