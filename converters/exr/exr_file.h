// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include <octet/core/base/types.h>

namespace octet {

/// An attribute in the header of an OpenEXR image.
struct ExrAttribute {
  std::string name;
  std::variant<std::string, int, double, Vec3, std::vector<float>> value;
};

/// One image of 32-bit float channels.
struct ExrPart {
  std::string name;  ///< unique in the file
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< unique; "layer.channel" puts it into a layer
  std::vector<ExrAttribute> attributes;
};

/// Pixels of part k: row by row from the top, channels interleaved in the part's order.
using ExrPixels = std::function<std::vector<float>(std::size_t part)>;

/// @brief Writes an OpenEXR file of scan lines, ZIP-compressed: a single-part file for one part, a
/// multi-part file for more. Pixels are asked for part by part, so that one part at a time is in
/// memory. The file appears complete or not at all.
/// @throws IoError, and what `pixels` throws
void writeExr(const std::vector<ExrPart>& parts, const ExrPixels& pixels, const std::string& path);

}  // namespace octet
