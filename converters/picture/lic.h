// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "slice.h"

namespace octet {

/// @brief Line integral convolution of a vector slice (Cabral and Leedom, 1993): white noise
/// smoothed along the field lines of the vectors' part in the plane, twice, and stretched to full
/// contrast. One brightness of 0 to 1 per pixel, mean about 1/2; 1/2 outside the domain and where
/// nothing flows in the plane. The noise
/// is a function of the pixel alone, so that the picture is the same every time.
/// @param reach  of the filter to each side along a line, pixels
std::vector<float> lineIntegralConvolution(const Slice& slice, double reach,
                                           const Context& context = {});

}  // namespace octet
