// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "noise_waves.h"
#include "primitive.h"

/// @file
/// Integrals of the primitives' velocities and vector potentials along straight segments from a to
/// b. Closed forms, but for the vortex ring (adaptive quadrature to 1e-12 of its scale). Potentials
/// A have curl A = v.

namespace octet {

/// @name Circulation of the vector potential along a segment
/// @{
double potentialAlong(const UniformFlow& flow, const Vec3& a, const Vec3& b);
double potentialAlong(const RigidRotation& rotation, const Vec3& a, const Vec3& b);
double potentialAlong(const VortexLine& line, const Vec3& a, const Vec3& b);
double potentialAlong(const VortexRing& ring, const Vec3& a, const Vec3& b);
double potentialAlong(const NoiseWaves& noise, const Vec3& a, const Vec3& b);
/// @}

/// @name Circulation of the velocity along a segment
/// A segment through a singular vortex line counts as passing it on neither side.
/// @{
double velocityAlong(const UniformFlow& flow, const Vec3& a, const Vec3& b);
double velocityAlong(const RigidRotation& rotation, const Vec3& a, const Vec3& b);
double velocityAlong(const VortexLine& line, const Vec3& a, const Vec3& b);
double velocityAlong(const VortexRing& ring, const Vec3& a, const Vec3& b);
double velocityAlong(const NoiseWaves& noise, const Vec3& a, const Vec3& b);
/// @}

/// @name Velocity at a point
/// @{
Vec3 velocityAt(const UniformFlow& flow, const Vec3& p);
Vec3 velocityAt(const RigidRotation& rotation, const Vec3& p);
Vec3 velocityAt(const VortexLine& line, const Vec3& p);
Vec3 velocityAt(const VortexRing& ring, const Vec3& p);
Vec3 velocityAt(const PointSource& source, const Vec3& p);
Vec3 velocityAt(const NoiseWaves& noise, const Vec3& p);
/// @}

/// Flux of a source through the triangle (a,b,c) towards its right-handed normal: a solid angle, by
/// the formula of van Oosterom and Strackee (1983); with a core that of a point moved away from the
/// triangle's plane. A source on the triangle sends half through it.
double fluxThrough(const PointSource& source, const Vec3& a, const Vec3& b, const Vec3& c);

/// Potential f of a source with grad f = v; 0 far away.
double potentialAt(const PointSource& source, const Vec3& p);

}  // namespace octet
