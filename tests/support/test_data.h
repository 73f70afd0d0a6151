// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octet::testing {

/// The path of a file or folder under tests/data.
std::string testData(const std::string& name);

}  // namespace octet::testing
