// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "picture.h"
#include "render.h"

namespace octet {

/// What is seen in the 3d view, and the colours' scale; null without a field.
struct SolidScene {
  Scene scene;
  std::vector<Vec3> extent;  ///< points that shall be seen
  std::optional<ColourScale> scale;
};

/// Streamlines or arrows of the field, cage, mesh and surface, in units of the domain's diagonal
/// around its middle. @throws InputError, Cancelled
SolidScene buildScene(const Subject& subject, const PictureOptions& options,
                      const Context& context = {});

/// Draws the whole domain in perspective.
void drawSolid(const Subject& subject, const PictureOptions& options, const std::string& path,
               const Context& context = {});

}  // namespace octet
