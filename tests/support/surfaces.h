// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include <octet/core/cage/triangle_surface.h>
#include <octet/core/topology/control_mesh.h>

/// @file
/// Closed surfaces for tests, made by code, the same on every machine.

namespace octet::testing {

/// A closed surface over the angles of a torus (u, v around it) or a sphere (u from pole to pole).
TriangleSurface surfaceOf(int n, int m, bool sphere, const std::function<Vec3(double, double)>& at);
TriangleSurface ball(double radius, const Vec3& centre = Vec3::Zero(), int n = 32);
TriangleSurface torus();
/// A ball with random bumps and dents, a few waves around it.
TriangleSurface blob(std::uint32_t seed);
/// A ball with two ears, a nose and a tail.
TriangleSurface bunnyLike();
Box boxOf(const Vec3& a, const Vec3& b);
/// An L of three unit cubes, 1 high: 22 of sharp edges, 12 corners, a volume of 3.
TriangleSurface ellSurface();
/// A cylinder around z with caps, of `n` long triangles around.
TriangleSurface cylinder(double radius, double height, int n);
TriangleSurface joined(TriangleSurface a, const TriangleSurface& b, bool reversed = false);

/// Of all cells, not signed.
double volumeOf(const ControlMesh& mesh);

}  // namespace octet::testing
