// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "../base/types.h"

namespace octet {

/// @brief A curve that the field is to follow: a polyline, tangent to which the field has a given
/// speed. World units; the curve runs in the order of its points and is closed when the last point
/// is the first.
struct GuideCurve {
  std::string name;
  std::vector<Vec3> points;
  std::vector<double> speeds;  ///< world units per second: one for all points, or one per point
  double weight = 1;           ///< relative to other guides, per unit of length
  std::string file;            ///< for messages; may be empty
  std::vector<std::string> places;  ///< where each point stands in the file; may be empty
};

/// @brief A vector that the field is to have at a point; counts like a curve that is one mean edge
/// of the cage long.
struct GuideVector {
  std::string name;
  Vec3 point, value;
  double weight = 1;
  std::string file, place;
};

struct Guides {
  std::vector<GuideCurve> curves;
  std::vector<GuideVector> vectors;
};

/// One equation v(point) = value of a least-squares fit.
struct GuideSample {
  Vec3 point, value;
  double weight;      ///< the guide's weight times the length it stands for, world units
  std::size_t guide;  ///< curves first, then vectors
  double along;       ///< arc length from the curve's start
  std::size_t row;    ///< point of the curve that it follows, for messages
};

/// Name of guide `k`: curves first, then vectors.
const std::string& guideName(const Guides& guides, std::size_t k);

/// "file: place" of a guide's point for an InputError.
std::string guidePlace(const GuideCurve& curve, std::size_t point);

/// @brief Equally spaced samples along curves, tangents turning evenly from point to point, and the
/// single vectors. Not more than `spacing` apart.
/// @param vectorLength  the length that a single vector stands for
/// @throws InputError (file, place) for a guide that is not finite, has no length, no speed, or a
/// weight that is not positive.
std::vector<GuideSample> sampleGuides(const Guides& guides, double spacing, double vectorLength);

}  // namespace octet
