// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/context.h"
#include "../geometry/box_bins.h"
#include "streamline.h"

namespace octet {

/// Points that fill a box evenly, the same ones always: Halton's sequence in the bases 2, 3, 5.
/// @param first  how many of the sequence to leave out
std::vector<Vec3> haltonPoints(const Box& box, std::size_t count, std::size_t first = 0);

/// Of a box' Halton points those inside a domain that keep a distance from all earlier ones, at
/// most `count`: where arrows stand.
std::vector<Vec3> spacedPoints(const std::function<bool(const Vec3&)>& inside, const Box& box,
                               std::size_t count, double distance);

/// Which streamlines fill a domain.
struct PlacementOptions {
  std::size_t count = 80;  ///< at most
  double separation = 0;   ///< no seed lies nearer to an earlier line, world units
  double shortest = 0;     ///< shorter lines are left out
  StreamlineOptions lines;
};

/// @brief Streamlines that fill a domain evenly: the box' Halton points, in their order, become
/// seeds unless an earlier line runs near. Lines are traced in parallel, in batches of one size, so
/// that the result does not depend on threads. @throws Cancelled
std::vector<Streamline> placeStreamlines(const VelocityFunction& velocity, const Box& box,
                                         const PlacementOptions& options,
                                         const Context& context = {});

}  // namespace octet
