// SPDX-License-Identifier: Apache-2.0
#include "colour_map.h"

#include <algorithm>
#include <cmath>

namespace octet {
namespace {

constexpr int kEntries = 17;
using Table = std::uint8_t[kEntries][3];

/// Every 16th of the 257 evenly spaced colours of viridis (public domain, CC0); in between linear,
/// which is within 2/255 of the full table.
constexpr Table kViridis = {
    {68, 1, 84},    {72, 24, 106},  {71, 45, 123},  {66, 64, 134},  {58, 82, 139},  {51, 99, 141},
    {44, 115, 142}, {38, 130, 142}, {32, 145, 140}, {31, 159, 136}, {40, 174, 128}, {62, 188, 116},
    {94, 201, 98},  {131, 212, 75}, {173, 220, 49}, {215, 226, 26}, {253, 231, 37}};

/// Computed by Moreland's rule (Diverging Color Maps for Scientific Visualization, 2009): straight
/// lines in the Msh colour space from (59, 76, 192) and from (180, 4, 38) to grey.
constexpr Table kCoolWarm = {{59, 76, 192},   {98, 100, 211},  {130, 123, 227}, {157, 145, 238},
                             {180, 166, 245}, {198, 185, 247}, {211, 201, 243}, {219, 213, 234},
                             {221, 221, 221}, {236, 211, 198}, {246, 196, 174}, {249, 176, 149},
                             {245, 153, 125}, {236, 126, 101}, {222, 96, 78},   {203, 61, 57},
                             {180, 4, 38}};

}  // namespace

Vec3 colourAt(ColourMap map, double t) {
  const Table& table = map == ColourMap::Viridis ? kViridis : kCoolWarm;
  const double place = std::clamp(t, 0.0, 1.0) * (kEntries - 1);
  const int k = std::min(static_cast<int>(place), kEntries - 2);
  const double part = place - k;
  Vec3 colour;
  for (int c = 0; c < 3; ++c) {
    colour[c] = ((1 - part) * table[k][c] + part * table[k + 1][c]) / 255;
  }
  return colour;
}

// IEC 61966-2-1.
double linearFromSrgb(double x) {
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}
double srgbFromLinear(double x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

}  // namespace octet
