// SPDX-License-Identifier: Apache-2.0
#include "guides.h"

#include <cmath>

#include "../base/error.h"

namespace octet {
namespace {

std::string quoted(const std::string& name) { return "guide \"" + name + "\""; }

void check(const GuideCurve& curve) {
  const auto fail = [&](std::size_t point, const std::string& reason) {
    throw InputError(curve.file, guidePlace(curve, point), reason);
  };
  if (curve.points.size() < 2) fail(0, "a curve needs two points or more");
  if (curve.speeds.size() != 1 && curve.speeds.size() != curve.points.size()) {
    fail(0, std::to_string(curve.speeds.size()) + " speeds for " +
                std::to_string(curve.points.size()) + " points");
  }
  for (std::size_t k = 0; k < curve.points.size(); ++k) {
    if (!curve.points[k].allFinite()) fail(k, "a coordinate is not a finite number");
    if (k > 0 && curve.points[k] == curve.points[k - 1]) {
      fail(k, "has zero length: the point before is at the same place");
    }
  }
  bool moves = false;
  for (std::size_t k = 0; k < curve.speeds.size(); ++k) {
    if (!std::isfinite(curve.speeds[k])) fail(k, "the speed is not a finite number");
    moves |= curve.speeds[k] != 0;
  }
  if (!moves) fail(0, "the speed is zero everywhere");
  if (!(curve.weight > 0) || !std::isfinite(curve.weight)) {
    fail(0, "the weight is not a positive number");
  }
}

void check(const GuideVector& vector) {
  const auto fail = [&](const std::string& reason) {
    throw InputError(vector.file, vector.place.empty() ? quoted(vector.name) : vector.place,
                     reason);
  };
  if (!vector.point.allFinite() || !vector.value.allFinite()) fail("a number is not finite");
  if (!(vector.weight > 0) || !std::isfinite(vector.weight)) {
    fail("the weight is not a positive number");
  }
}

/// Unit tangents at the points: the mean of the directions before and after.
std::vector<Vec3> tangents(const std::vector<Vec3>& points) {
  const std::size_t n = points.size();
  const bool closed = n > 3 && points.front() == points.back();
  std::vector<Vec3> directions(n - 1);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    directions[k] = (points[k + 1] - points[k]).normalized();
  }
  std::vector<Vec3> result(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3& after = k + 1 < n ? directions[k] : closed ? directions.front() : directions.back();
    const Vec3& before = k > 0    ? directions[k - 1]
                         : closed ? directions.back()
                                  : directions.front();
    const Vec3 sum = before + after;
    constexpr double kTurnsBack = 1e-6;  // then there is no tangent: go on with the next direction
    result[k] = sum.norm() > kTurnsBack ? Vec3(sum.normalized()) : after;
  }
  return result;
}

void sampleCurve(const GuideCurve& curve, std::size_t guide, double spacing,
                 std::vector<GuideSample>* samples) {
  const std::vector<Vec3> tangent = tangents(curve.points);
  const auto speed = [&](std::size_t k) {
    return curve.speeds.size() == 1 ? curve.speeds[0] : curve.speeds[k];
  };
  double along = 0;
  for (std::size_t k = 0; k + 1 < curve.points.size(); ++k) {
    const Vec3 step = curve.points[k + 1] - curve.points[k];
    const double length = step.norm();
    const int parts = std::max(1, static_cast<int>(std::ceil(length / spacing)));
    for (int part = 0; part < parts; ++part) {
      const double t = (part + 0.5) / parts;
      Vec3 direction = (1 - t) * tangent[k] + t * tangent[k + 1];
      direction = direction.norm() > 0 ? Vec3(direction.normalized()) : Vec3(step / length);
      samples->push_back(
          {curve.points[k] + t * step,
           ((1 - t) * speed(k) + t * speed(k + 1 < curve.speeds.size() ? k + 1 : k)) * direction,
           curve.weight * length / parts, guide, along + t * length, k});
    }
    along += length;
  }
}

}  // namespace

const std::string& guideName(const Guides& guides, std::size_t k) {
  return k < guides.curves.size() ? guides.curves[k].name
                                  : guides.vectors[k - guides.curves.size()].name;
}

std::string guidePlace(const GuideCurve& curve, std::size_t point) {
  if (point < curve.places.size()) return curve.places[point] + ", " + quoted(curve.name);
  return quoted(curve.name) + ", point " + std::to_string(point + 1);
}

std::vector<GuideSample> sampleGuides(const Guides& guides, double spacing, double vectorLength) {
  std::vector<GuideSample> samples;
  std::size_t guide = 0;
  for (const GuideCurve& curve : guides.curves) {
    check(curve);
    sampleCurve(curve, guide++, spacing, &samples);
  }
  for (const GuideVector& vector : guides.vectors) {
    check(vector);
    samples.push_back({vector.point, vector.value, vector.weight * vectorLength, guide++, 0, 0});
  }
  return samples;
}

}  // namespace octet
