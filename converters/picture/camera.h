// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <octet/core/base/types.h>

namespace octet {

/// Where a picture is taken from: around the domain's middle, in degrees.
struct Camera {
  double azimuth = -60;   ///< around the up axis; 0 stands on the side of the first axis (+x)
  double elevation = 22;  ///< above the horizon, -90 to 90
  double zoom = 1;        ///< 1: the domain just fills the picture
};

/// @brief A perspective view: which ray passes through a place in the picture.
class View {
 public:
  /// @param upAxis  'Y' or 'Z'
  /// @param points  which shall all be seen when the zoom is 1
  /// @param room  part of the picture's width and height that they may fill, 0 to 1
  View(const Camera& camera, char upAxis, const std::vector<Vec3>& points, int width, int height,
       double room);

  const Vec3& eye() const { return eye_; }
  /// Unit vectors: to the right, up, and towards the viewer.
  const Vec3& right() const { return right_; }
  const Vec3& up() const { return up_; }
  const Vec3& back() const { return back_; }
  /// Direction, not of unit length, through a place in pixels from the upper left corner.
  Vec3 direction(double x, double y) const;

 private:
  Vec3 eye_, right_, up_, back_;
  int width_, height_;
  double pixel_;  // edge of a pixel in a plane at distance 1
};

}  // namespace octet
