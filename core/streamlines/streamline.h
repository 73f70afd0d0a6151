// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "../base/types.h"

namespace octet {

/// The velocity at a point in world units; false outside the domain, the velocity is then
/// untouched. Where it is not finite counts as outside. Must be thread safe where streamlines are
/// traced in parallel.
using VelocityFunction = std::function<bool(const Vec3& point, Vec3* velocity)>;

/// How exactly and how far a streamline is followed. Lengths are in world units.
struct StreamlineOptions {
  double tolerance = 1e-6;        ///< estimated error of one step, per coordinate
  double longestStep = HUGE_VAL;  ///< so that the points alone draw a smooth curve
  double longest = HUGE_VAL;      ///< stop at this length, to the tolerance
  double longestTime = HUGE_VAL;  ///< stop at this time, exactly
  double slowest = 0;             ///< stop where the speed is at most this
  double closing = 0;             ///< stop on coming back this near to the seed; 0: never
  int mostSteps = 100000;         ///< tried ones, not only those taken
};

/// Why a streamline ends.
enum class StreamlineEnd : std::uint8_t { Boundary, Length, Time, Standstill, Closed, Steps };

/// A point of a streamline; `time` counts from the seed, backwards it is negative.
struct StreamlinePoint {
  Vec3 position, velocity;
  double time;
};

/// A streamline through its seed, along the flow. Between two points it is, to the tolerance, the
/// cubic Hermite curve through their positions and velocities.
struct Streamline {
  std::vector<StreamlinePoint> points;  ///< empty when the seed lies outside the domain
  std::size_t seed = 0;                 ///< which point is the seed
  StreamlineEnd first = StreamlineEnd::Standstill, last = StreamlineEnd::Standstill;

  double length() const;  ///< of the polyline
};

/// @brief Follows dx/dt = velocity(x) from a seed until something ends it: Dormand and Prince's
/// embedded pair of orders 5 and 4 with step size control, by Boost.odeint. A step that would leave
/// the domain is halved until it is shorter than the tolerance, so that the last point lies inside
/// and that near to the boundary.
/// @param direction  +1 downstream, -1 upstream (the points then run against the flow)
Streamline traceStreamline(const VelocityFunction& velocity, const Vec3& seed,
                           const StreamlineOptions& options, int direction = 1);

/// Both ways from the seed; each way has the options' limits for itself. A line that closes is
/// followed downstream only.
Streamline traceBothWays(const VelocityFunction& velocity, const Vec3& seed,
                         const StreamlineOptions& options);

}  // namespace octet
