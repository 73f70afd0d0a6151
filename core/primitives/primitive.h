// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>

#include "../base/types.h"

/// @file
/// Analytic velocity fields, in world units and seconds. All but the source are free of divergence.

namespace octet {

struct UniformFlow {
  Vec3 velocity = Vec3::Zero();
};

/// Turns like a rigid body: v = omega x (p - centre).
struct RigidRotation {
  Vec3 centre = Vec3::Zero();
  Vec3 angularVelocity = Vec3::Zero();  ///< radians per second
};

/// An endless straight vortex. At distance r it turns with circulation / (2 pi) r / (r^2 + core^2):
/// like 1/r outside the core (Scully's vortex). core = 0 is the singular line.
struct VortexLine {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();  ///< of the vorticity; any length
  double circulation = 0;
  double core = 0;
};

/// A circular vortex. The core softens the Biot-Savart kernel, distance^2 + core^2 instead of
/// distance^2 (Rosenhead and Moore), so the field stays exactly free of divergence.
struct VortexRing {
  Vec3 centre = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< direction of the flow through the ring; any length
  double radius = 1;
  double circulation = 0;
  double core = 0;
};

/// A point source, or sink: v = strength / (4 pi) r / (|r|^2 + core^2)^(3/2).
struct PointSource {
  Vec3 point = Vec3::Zero();
  double strength = 0;  ///< volume per second
  double core = 0;
};

/// The curl of a sum of random waves: turbulence without divergence, the same for a seed on every
/// machine. Wave numbers lie between those of the two wavelengths, equally many per octave, with
/// the energy spectrum E(k) ~ k^-exponent; the mean square velocity over all space is speed^2.
/// Wavelengths below two edges of the cage cannot be told apart by it.
struct CurlNoise {
  double speed = 1;                     ///< root mean square
  double longest = 1, shortest = 0.25;  ///< wavelengths
  double exponent = 5.0 / 3;            ///< Kolmogorov's
  std::uint32_t seed = 0;
  int waves = 64;
};

using Primitive =
    std::variant<UniformFlow, RigidRotation, VortexLine, VortexRing, PointSource, CurlNoise>;

/// "vortex ring" and so on, for messages.
std::string nameOf(const Primitive& primitive);

/// @throws InputError for numbers that are not finite, a direction without length, a radius or
/// wavelength that is not positive, a negative core.
void checkPrimitive(const Primitive& primitive);

}  // namespace octet
