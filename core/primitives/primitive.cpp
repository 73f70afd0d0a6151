// SPDX-License-Identifier: Apache-2.0
#include "primitive.h"

#include <cmath>

#include "../base/error.h"

namespace octet {
namespace {

/// More waves than this take hours and look no different.
constexpr int kMostWaves = 100000;

class Checker {
 public:
  void operator()(const UniformFlow& p) const { finite("velocity", p.velocity); }
  void operator()(const RigidRotation& p) const {
    finite("centre", p.centre);
    finite("angular velocity", p.angularVelocity);
  }
  void operator()(const VortexLine& p) const {
    finite("point", p.point);
    direction("direction", p.direction);
    finite("circulation", p.circulation);
    core(p.core);
  }
  void operator()(const VortexRing& p) const {
    finite("centre", p.centre);
    direction("normal", p.normal);
    positive("radius", p.radius);
    finite("circulation", p.circulation);
    core(p.core);
  }
  void operator()(const PointSource& p) const {
    finite("point", p.point);
    finite("strength", p.strength);
    core(p.core);
  }
  void operator()(const CurlNoise& p) const {
    finite("speed", p.speed);
    positive("longest wavelength", p.longest);
    positive("shortest wavelength", p.shortest);
    finite("exponent", p.exponent);
    if (p.shortest > p.longest) fail("shortest wavelength", "is longer than the longest");
    if (p.waves < 1 || p.waves > kMostWaves) {
      fail("waves", "are not between 1 and " + std::to_string(kMostWaves));
    }
  }

 private:
  [[noreturn]] static void fail(const std::string& what, const std::string& reason) {
    throw InputError(what, reason);
  }
  static void finite(const char* what, double x) {
    if (!std::isfinite(x)) fail(what, "is not a finite number");
  }
  static void finite(const char* what, const Vec3& x) {
    if (!x.allFinite()) fail(what, "is not finite");
  }
  static void positive(const char* what, double x) {
    if (!(x > 0) || !std::isfinite(x)) fail(what, "is not a positive number");
  }
  static void direction(const char* what, const Vec3& x) {
    finite(what, x);
    if (!(x.norm() > 0) || !std::isfinite(x.norm())) fail(what, "has no length");
  }
  static void core(double x) {
    if (!(x >= 0) || !std::isfinite(x)) fail("core", "is negative or not finite");
  }
};

}  // namespace

std::string nameOf(const Primitive& primitive) {
  constexpr const char* kNames[] = {"uniform flow", "rotation", "vortex line",
                                    "vortex ring",  "source",   "curl noise"};
  return kNames[primitive.index()];
}

void checkPrimitive(const Primitive& primitive) {
  try {
    std::visit(Checker(), primitive);
  } catch (const InputError& e) {
    throw InputError(nameOf(primitive), e.place() + " " + e.reason());
  }
}

}  // namespace octet
