// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../picture/slice.h"

namespace octet {

/// Which slices of a subject become float images. Sizes are in pixels, the rest in world units.
struct SliceExrOptions {
  int axis = 2;
  std::optional<double> position{};  ///< of a single slice; absent: the middle
  int stack = 1;       ///< slices, evenly through the domain, each in the middle of its share
  bool atlas = false;  ///< side by side in one image instead of one part each
  int width = 1280, height = 720;           ///< of a slice, at most
  Quantity quantity = Quantity::Automatic;  ///< Automatic: all components of the field
  double spacing = 0;                       ///< of differences; 0: the subject's detail
  bool rgb = false;                         ///< a vector as R G B instead of a layer
  std::string layer = "velocity";           ///< of a vector: layer.X .Y .Z
};

/// @brief Writes slices as 32-bit floats to an OpenEXR file, one part per slice or an atlas.
///
/// Channels: of a vector `layer.X .Y .Z` or R G B; of a scalar one named after the form; of a
/// quantity one of that name; `Y` where such a name cannot be a channel's. Besides A: 1 in the
/// domain, 0 outside, where all values are 0.
///
/// Header attributes: octet.source, .form, .quantity and .degree of what is shown, .unit of the
/// form's coefficients; octet.axis ("x", "y", "z") and .position of the slice, .right and .up for
/// the picture's axes; octet.spacing between pixel centres; octet.worldMin and .worldMax of the
/// pixels' outer edges, flat along the axis; octet.differences, the distance to each side in
/// divergence and curl; of a stack octet.sliceSpacing. An atlas has octet.atlasColumns, .atlasRows
/// and .positions: slice k lies in column k mod columns, row k div columns from the top, and its
/// worldMin and worldMax are those of all slices, from the first position to the last.
/// @throws InputError, IoError, Cancelled
void writeSliceExr(const Subject& subject, const SliceExrOptions& options, const std::string& path,
                   const Context& context = {});

}  // namespace octet
