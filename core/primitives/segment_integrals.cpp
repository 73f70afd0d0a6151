// SPDX-License-Identifier: Apache-2.0
#include "segment_integrals.h"

#include <cmath>

#include "../base/error.h"
#include "../base/numbers.h"
#include "../forms/de_rham.h"

namespace octet {
namespace {

/// Ten points integrate to rounding what has its singularities two lengths away: the error falls
/// like (4 + sqrt(17))^(-20).
constexpr int kGaussPoints = 10;
constexpr double kFarAway = 2;

/// Error allowed in each interval of adaptive quadrature, times the ring's circulation.
constexpr double kPerInterval = 1e-14;
/// A source nearer to a triangle's edge than some of this times its size lies on it.
constexpr double kOnEdge = 1e-13;

const GaussRule& gauss() {
  static const GaussRule rule(kGaussPoints);
  return rule;
}

/// Integral over [from, to] of f, halving where two halves and the whole differ by more than
/// `tolerance` and rounding. A logarithmic singularity takes one path of halvings, some 45.
template <typename Function>
double quadrature(const Function& f, double from, double to, double tolerance, int depth = 0) {
  constexpr int kDeepest = 45;
  constexpr double kRounding = 4e-16;
  double size = 0;
  const auto on = [&](double a, double b) {
    double sum = 0;
    for (int k = 0; k < kGaussPoints; ++k) {
      const double term = gauss().weights[k] * f(a + gauss().points[k] * (b - a)) * (b - a);
      sum += term;
      size += std::abs(term);
    }
    return sum;
  };
  const double middle = (from + to) / 2;
  const double whole = on(from, to), halves = on(from, middle) + on(middle, to);
  if (depth >= kDeepest || std::abs(whole - halves) <= tolerance + kRounding * size) return halves;
  return quadrature(f, from, middle, tolerance, depth + 1) +
         quadrature(f, middle, to, tolerance, depth + 1);
}

double sinc(double x) { return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x; }

/// A segment seen along a vortex line: its start and step at right angles to the line.
struct AcrossLine {
  AcrossLine(const VortexLine& line, const Vec3& a, const Vec3& b) {
    axis = line.direction.normalized();
    const Vec3 r = a - line.point, e = b - a;
    along = e.dot(axis);
    start = r - r.dot(axis) * axis;
    step = e - along * axis;
    alpha = step.squaredNorm();
    turn = axis.dot(start.cross(step));
    core2 = line.core * line.core;
  }

  /// Squared distance from the line, core included, at parameter s: alpha ((s - s0)^2 + q^2).
  double squared(double s) const { return (start + s * step).squaredNorm() + core2; }
  double s0() const { return -start.dot(step) / alpha; }
  double q() const { return std::sqrt((turn * turn / alpha + core2) / alpha); }

  Vec3 axis, start, step;
  double along, alpha, turn, core2;
};

/// Bulirsch's general complete elliptic integral of (a cos^2 + b sin^2) / ((cos^2 + p sin^2)
/// sqrt(cos^2 + kc^2 sin^2)) over [0, pi/2], for kc, p > 0 (R. Bulirsch, Numerical calculation of
/// elliptic integrals and elliptic functions III, 1969).
double ellipticIntegral(double kc, double p, double a, double b) {
  double e = kc, em = 1;
  p = std::sqrt(p);
  b /= p;
  double f = a;
  a += b / p;
  double g = e / p;
  b = 2 * (b + f * g);
  p += g;
  g = em;
  em += kc;
  // Differences are squared at each step.
  constexpr double kClose = 1e-8;
  while (std::abs(g - kc) > g * kClose) {
    kc = 2 * std::sqrt(e);
    e = kc * em;
    f = a;
    a += b / p;
    g = e / p;
    b = 2 * (b + f * g);
    p += g;
    g = em;
    em += kc;
  }
  return kPi / 2 * (b + a * em) / (em * (em + p));
}

/// A point seen from a ring: distance from its axis, height, and the elliptic integrals' scale.
struct AtRing {
  AtRing(const VortexRing& ring, const Vec3& p) {
    axis = ring.normal.normalized();
    const Vec3 r = p - ring.centre;
    height = r.dot(axis);
    out = r - height * axis;
    distance = out.norm();
    const double rest = height * height + ring.core * ring.core;
    const double sum = ring.radius + distance, difference = ring.radius - distance;
    size = std::sqrt(sum * sum + rest);
    kc2 = (difference * difference + rest) / (size * size);
  }

  Vec3 axis, out;
  double height, distance, size, kc2;
};

}  // namespace

// ---- vector potentials --------------------------------------------------------------------------

// For a field homogeneous of degree n without divergence, curl (v x r) = (n + 2) v.
double potentialAlong(const UniformFlow& flow, const Vec3& a, const Vec3& b) {
  return flow.velocity.cross(a).dot(b - a) / 2;  // (v x r) . e is constant along e
}

double potentialAlong(const RigidRotation& rotation, const Vec3& a, const Vec3& b) {
  const Vec3 p = a - rotation.centre, q = b - rotation.centre, w = rotation.angularVelocity;
  const auto at = [&](const Vec3& r) -> Vec3 { return w.cross(r).cross(r) / 3; };
  return (at(p) + 4 * at((p + q) / 2) + at(q)).dot(q - p) / 6;  // Simpson, for quadratics exact
}

// A = - circulation / (4 pi) log(distance^2 + core^2) along the line.
double potentialAlong(const VortexLine& line, const Vec3& a, const Vec3& b) {
  const AcrossLine at(line, a, b);
  const double nearest = at.alpha > 0 ? std::min(1.0, std::max(0.0, at.s0())) : 0;
  double integral = 0;
  if (at.squared(nearest) > kFarAway * kFarAway * at.alpha) {
    for (int k = 0; k < kGaussPoints; ++k) {
      integral += gauss().weights[k] * std::log(at.squared(gauss().points[k]));
    }
  } else if (at.alpha > 0) {
    const double q = at.q();
    const auto antiderivative = [&](double u) {
      const double square = u * u + q * q;
      return (square > 0 ? u * std::log(square) : 0) - 2 * u + 2 * q * std::atan2(u, q);
    };
    integral = std::log(at.alpha) + antiderivative(1 - at.s0()) - antiderivative(-at.s0());
  } else {
    throw InputError(nameOf(line), "has no core and runs along an edge of the cage");
  }
  return -line.circulation / (4 * kPi) * at.along * integral;
}

double potentialAlong(const VortexRing& ring, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const auto along = [&](double s) {
    const AtRing at(ring, a + s * e);
    if (at.distance == 0 || at.kc2 == 0) return 0.0;
    const double size = ring.circulation * ring.radius / (kPi * at.size) *
                        ellipticIntegral(std::sqrt(at.kc2), 1, -1, 1);
    return size * at.axis.cross(at.out).dot(e) / at.distance;
  };
  return quadrature(along, 0, 1, kPerInterval * std::abs(ring.circulation) * e.norm());
}

double potentialAlong(const NoiseWaves& noise, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a, middle = (a + b) / 2;
  double sum = 0;
  for (const NoiseWave& w : noise) {
    sum += w.amplitude.dot(e) * std::cos(w.wave.dot(middle) + w.phase) * sinc(w.wave.dot(e) / 2);
  }
  return sum;
}

// ---- velocities ---------------------------------------------------------------------------------

double velocityAlong(const UniformFlow& flow, const Vec3& a, const Vec3& b) {
  return flow.velocity.dot(b - a);
}

double velocityAlong(const RigidRotation& rotation, const Vec3& a, const Vec3& b) {
  return velocityAt(rotation, (a + b) / 2).dot(b - a);
}

// The angle by which the segment turns around the line, less within the core.
double velocityAlong(const VortexLine& line, const Vec3& a, const Vec3& b) {
  const AcrossLine at(line, a, b);
  if (at.alpha == 0 || at.turn == 0) return 0;
  const double q = at.q(), s0 = at.s0();
  const double angle = std::atan2(q, q * q - s0 * (1 - s0));
  return line.circulation / (2 * kPi) * at.turn * angle / (at.alpha * q);
}

double velocityAlong(const VortexRing& ring, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const auto along = [&](double s) { return velocityAt(ring, a + s * e).dot(e); };
  const double least = ring.core > 0 ? std::min(ring.core, ring.radius) : ring.radius;
  return quadrature(along, 0, 1, kPerInterval * std::abs(ring.circulation) * e.norm() / least);
}

double velocityAlong(const NoiseWaves& noise, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a, middle = (a + b) / 2;
  double sum = 0;
  for (const NoiseWave& w : noise) {
    sum -= w.wave.cross(w.amplitude).dot(e) * std::sin(w.wave.dot(middle) + w.phase) *
           sinc(w.wave.dot(e) / 2);
  }
  return sum;
}

Vec3 velocityAt(const UniformFlow& flow, const Vec3&) { return flow.velocity; }

Vec3 velocityAt(const RigidRotation& rotation, const Vec3& p) {
  return rotation.angularVelocity.cross(p - rotation.centre);
}

Vec3 velocityAt(const VortexLine& line, const Vec3& p) {
  const AcrossLine at(line, p, p);
  const double squared = at.squared(0);
  if (squared == 0) return Vec3::Zero();
  return line.circulation / (2 * kPi * squared) * at.axis.cross(at.start);
}

Vec3 velocityAt(const VortexRing& ring, const Vec3& p) {
  const AtRing at(ring, p);
  if (at.kc2 == 0) return Vec3::Zero();
  const double kc = std::sqrt(at.kc2), r = ring.radius, d = at.distance;
  const double scale = ring.circulation * r / (kPi * at.size * at.size * at.size);
  Vec3 v = scale * ellipticIntegral(kc, at.kc2, r + d, r - d) * at.axis;
  if (d > 0) v += scale * at.height / d * ellipticIntegral(kc, at.kc2, -1, 1) * at.out;
  return v;
}

Vec3 velocityAt(const PointSource& source, const Vec3& p) {
  const Vec3 r = p - source.point;
  const double squared = r.squaredNorm() + source.core * source.core;
  if (squared == 0) return Vec3::Zero();
  return source.strength / (4 * kPi * squared * std::sqrt(squared)) * r;
}

Vec3 velocityAt(const NoiseWaves& noise, const Vec3& p) {
  Vec3 v = Vec3::Zero();
  for (const NoiseWave& w : noise) {
    v -= std::sin(w.wave.dot(p) + w.phase) * w.wave.cross(w.amplitude);
  }
  return v;
}

// ---- sources ------------------------------------------------------------------------------------

double fluxThrough(const PointSource& source, const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 p = a - source.point, q = b - source.point, r = c - source.point;
  double share = 1;
  if (source.core > 0) {
    // In the triangle's plane at height h, h / (d^2 + h^2 + core^2)^(3/2) is that of a point at
    // height sqrt(h^2 + core^2), times h over it.
    const Vec3 normal = (b - a).cross(c - a).normalized();
    const double h = p.dot(normal), height = std::hypot(h, source.core);
    for (Vec3* x : {&p, &q, &r}) *x += (height - h) * normal;
    share = h / height;
  }
  const double l = p.norm(), m = q.norm(), n = r.norm();
  const double up = p.dot(q.cross(r));
  const double side = l * m * n + p.dot(q) * n + p.dot(r) * m + q.dot(r) * l;
  // On an edge or a vertex both are rounding, and the flux stays in the triangle's plane.
  if (std::hypot(up, side) <= kOnEdge * l * m * n) return 0;
  return source.strength / (4 * kPi) * share * 2 * std::atan2(up, side);
}

double potentialAt(const PointSource& source, const Vec3& p) {
  return -source.strength / (4 * kPi * std::hypot((p - source.point).norm(), source.core));
}

}  // namespace octet
