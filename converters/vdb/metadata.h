// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace octet {

/// Names of metadata that are read again.
inline constexpr const char* kMethodMetadata = "octet_method";
inline constexpr const char* kSampledMetadata = "octet_sampled_voxels";
inline constexpr const char* kFrameMetadata = "octet_frame";

/// A piece of grid or file metadata.
struct VdbMetadata {
  std::string name;
  std::variant<std::string, double, std::int32_t> value;
};

}  // namespace octet
