// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/base/context.h>

#include "camera.h"
#include "scene.h"

namespace octet {

/// Linear light, row by row from the top: red, green, blue and the part of the pixel that is
/// covered; colours are premultiplied by it, and no background is added.
struct RenderedImage {
  int width = 0, height = 0;
  std::vector<std::array<float, 4>> pixels;
};

/// @brief Ray traces a scene with Embree: a key light from the upper left of the viewer, ambient
/// light less where nearby things block it, surfaces seen through, 4 rays a pixel and 16 where
/// neighbours differ. The same bytes at any number of threads.
/// @throws Error when Embree fails, Cancelled
RenderedImage render(const Scene& scene, const View& view, int width, int height,
                     const Context& context = {});

}  // namespace octet
