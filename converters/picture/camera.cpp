// SPDX-License-Identifier: Apache-2.0
#include "camera.h"

#include <algorithm>
#include <cmath>

#include <octet/core/base/numbers.h>

namespace octet {
namespace {

/// Angle of view over the picture's height: a long lens, for calm perspective.
constexpr double kFieldOfView = 26 * kPi / 180;

}  // namespace

View::View(const Camera& camera, char upAxis, const std::vector<Vec3>& points, int width,
           int height, double room)
    : width_(width), height_(height), pixel_(2 * std::tan(kFieldOfView / 2) / height) {
  const double azimuth = camera.azimuth * kPi / 180, elevation = camera.elevation * kPi / 180;
  const auto turned = [&](double x, double y, double z) {
    return upAxis == 'Y' ? Vec3(x, z, -y) : Vec3(x, y, z);
  };
  back_ = turned(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                 std::sin(elevation));
  right_ = turned(-std::sin(azimuth), std::cos(azimuth), 0);
  up_ = back_.cross(right_);

  // In the camera's axes a point is seen inside a cone |a| <= slope * depth. The narrowest eye
  // position: across, between the outermost planes on both sides; then as near as they allow.
  const double slope[2] = {room * pixel_ * width / 2, room * pixel_ * height / 2};
  double offset[2] = {0, 0}, distance = 0;
  for (int k = 0; k < 2; ++k) {
    const Vec3& axis = k == 0 ? right_ : up_;
    double high = -HUGE_VAL, low = -HUGE_VAL;
    for (const Vec3& p : points) {
      // a - e <= slope (d - b) and e - a <= slope (d - b), with b the place along back_.
      high = std::max(high, axis.dot(p) + slope[k] * back_.dot(p));
      low = std::max(low, -axis.dot(p) + slope[k] * back_.dot(p));
    }
    if (points.empty()) high = low = slope[k];
    offset[k] = (high - low) / 2;
    distance = std::max(distance, (high + low) / (2 * slope[k]));
  }
  // Zooming moves the eye towards the points' middle.
  double nearest = -HUGE_VAL;
  for (const Vec3& p : points) nearest = std::max(nearest, back_.dot(p));
  if (points.empty()) nearest = 0;
  pixel_ /= camera.zoom;
  distance = std::max(distance, nearest + 1e-3);
  eye_ = offset[0] * right_ + offset[1] * up_ + distance * back_;
}

Vec3 View::direction(double x, double y) const {
  return pixel_ * (x - width_ / 2.0) * right_ - pixel_ * (y - height_ / 2.0) * up_ - back_;
}

}  // namespace octet
