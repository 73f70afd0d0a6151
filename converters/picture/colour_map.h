// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/base/types.h>

namespace octet {

/// Colour maps of even steps in perceived colour.
enum class ColourMap : std::uint8_t {
  Viridis,   ///< dark blue, green, yellow: for what has a size (van der Walt and Smith, 2015)
  CoolWarm,  ///< blue, light grey, red: for what has a sign (Moreland, 2009)
};

/// sRGB colour, 0 to 1 each, at 0 <= t <= 1; beyond that the ends' colours.
Vec3 colourAt(ColourMap map, double t);

/// A map over a range of values.
struct ColourScale {
  ColourMap map = ColourMap::Viridis;
  double min = 0, max = 1;

  Vec3 at(double value) const {
    return colourAt(map, max > min ? (value - min) / (max - min) : 0.5);
  }
};

/// One channel between sRGB and linear light, 0 to 1.
double linearFromSrgb(double x);
double srgbFromLinear(double x);

}  // namespace octet
