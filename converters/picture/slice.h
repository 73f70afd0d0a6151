// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "subject.h"

namespace octet {

/// What is shown of a field.
enum class Quantity : std::uint8_t {
  Automatic,  ///< a vector's magnitude, a scalar itself
  Magnitude,
  X,
  Y,
  Z,
  Divergence,  ///< by central differences
  Curl,        ///< its magnitude, by central differences
};

/// "magnitude", "divergence", ...
const char* quantityName(Quantity quantity);

/// @brief Square pixels in a plane across an axis, seen against the axis: the picture's right is
/// +y, +x, +x for axis x, y, z and its upper side +z, +z, +y. Row 0 is the uppermost.
struct SliceGrid {
  int axis = 2;
  double position = 0;        ///< along the axis, world units
  int width = 0, height = 0;  ///< pixels
  double spacing = 0;         ///< edge of a pixel, world units
  double left = 0, top = 0;   ///< world coordinates of the outer edges

  int rightAxis() const { return axis == 0 ? 1 : 0; }
  int upAxis() const { return axis == 2 ? 1 : 2; }
  /// World position of a point in pixels from the upper left corner; pixel centres are at halves.
  Vec3 point(double x, double y) const;
  /// The inverse, for points in the plane.
  Eigen::Vector2d pixel(const Vec3& point) const;
  /// World box of the pixels, flat along the axis.
  Box box() const;
};

/// The largest grid of at most `width` x `height` pixels over a domain.
/// @param position  absent: the middle of the domain
/// @throws InputError when the position lies outside the domain's box
SliceGrid fitSlice(const Subject& subject, int axis, std::optional<double> position, int width,
                   int height);

/// Values on a grid, row by row from the top; 0 where `inside` is 0.
struct Slice {
  SliceGrid grid;
  int components = 1;
  std::vector<double> values;
  std::vector<std::uint8_t> inside;

  const double* at(int x, int y) const {
    return &values[(static_cast<std::size_t>(y) * grid.width + x) * components];
  }
  bool isInside(int x, int y) const {
    return inside[static_cast<std::size_t>(y) * grid.width + x] != 0;
  }
};

/// The field's own components at the pixels' centres. @throws Cancelled
Slice sampleSlice(const Subject& subject, const SliceGrid& grid, const Context& context = {});

/// A quantity of one component. A difference needs all six points around the pixel, `spacing` away
/// along the axes, in the domain.
/// @throws InputError for a quantity that the field does not have, Cancelled
Slice sampleQuantity(const Subject& subject, const SliceGrid& grid, Quantity quantity,
                     double spacing, const Context& context = {});

/// @throws InputError unless the subject has a field of which `quantity` can be taken.
void checkQuantity(const Subject& subject, Quantity quantity);

}  // namespace octet
