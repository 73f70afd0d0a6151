// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace octet {

/// Names and versions of the libraries below core and converters, as they are at run time where
/// these tell it, else as they were when this was built.
std::vector<std::pair<std::string, std::string>> libraryVersions();

}  // namespace octet
