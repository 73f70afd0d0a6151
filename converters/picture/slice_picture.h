// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "canvas.h"
#include "picture.h"

namespace octet {

/// Draws a slice: colours, and on them line integral convolution or arrows.
void drawSlice(const Subject& subject, const PictureOptions& options, const std::string& path,
               const Context& context = {});

}  // namespace octet
