// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace octet {

/// A piece of grid or file metadata.
struct VdbMetadata {
  std::string name;
  std::variant<std::string, double, std::int32_t> value;
};

}  // namespace octet
