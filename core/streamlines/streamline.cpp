// SPDX-License-Identifier: Apache-2.0
#include "streamline.h"

#include <algorithm>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

namespace octet {
namespace {

namespace odeint = boost::numeric::odeint;

using State = std::array<double, 3>;
using Stepper = odeint::runge_kutta_dopri5<State>;
using Controlled = odeint::controlled_runge_kutta<Stepper>;

State toState(const Vec3& v) { return {v[0], v[1], v[2]}; }
Vec3 toVector(const State& s) { return {s[0], s[1], s[2]}; }

/// The first step is this part of what the speed and the tolerance suggest for an O(1) curvature.
constexpr double kFirstStep = 0.1;
/// A line counts as coming back only after it has left by this many closing distances.
constexpr double kLeaving = 3;

/// Distance of a point from a segment.
double distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double squared = ab.squaredNorm();
  const double t = squared > 0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

class Tracer {
 public:
  Tracer(const VelocityFunction& velocity, const StreamlineOptions& options, int direction)
      : velocity_(velocity),
        options_(options),
        direction_(direction),
        stepper_(odeint::default_error_checker<double, odeint::array_algebra,
                                               odeint::default_operations>(options.tolerance, 0)) {}

  Streamline run(const Vec3& seed) {
    Vec3 v;
    if (!velocity_(seed, &v) || !v.allFinite()) return line_;
    x_ = toState(seed);
    slope_ = toState(direction_ * v);
    store();
    const double speed = v.norm();
    if (speed > 0) dt_ = kFirstStep * std::pow(options_.tolerance, 0.2) / speed;
    for (int step = 0; step < options_.mostSteps; ++step) {
      if (ended()) return line_;
      advance();
    }
    line_.last = StreamlineEnd::Steps;
    return line_;
  }

 private:
  double speed() const { return toVector(slope_).norm(); }

  bool end(StreamlineEnd why) {
    line_.last = why;
    return true;
  }
  bool ended() {
    if (atBoundary_) return end(StreamlineEnd::Boundary);
    if (closed_) return end(StreamlineEnd::Closed);
    if (time_ >= options_.longestTime) return end(StreamlineEnd::Time);
    if (length_ >= options_.longest) return end(StreamlineEnd::Length);
    const double now = speed();
    if (!(now > options_.slowest)) return end(StreamlineEnd::Standstill);
    return false;
  }

  /// One attempt at a step.
  void advance() {
    const double now = speed();
    const double left = options_.longestTime - time_;
    double dt = std::min({dt_, options_.longestStep / now, (options_.longest - length_) / now});
    const bool last = dt >= left;
    if (last) dt = left;
    const double tried = dt;
    double time = time_;
    State x, slope;
    bool inside = true;
    const auto system = [&](const State& at, State& derivative, double) {
      Vec3 v = Vec3::Zero();
      if (inside && !(velocity_(toVector(at), &v) && v.allFinite())) inside = false;
      derivative = toState(direction_ * v);
    };
    const auto result = stepper_.try_step(system, x_, slope_, time, x, slope, dt);
    if (!inside) {
      dt_ = tried / 2;
      atBoundary_ = tried * now < options_.tolerance;
      return;
    }
    if (result != odeint::success) {
      dt_ = dt;
      return;
    }
    // The length's end asks for short last steps: a step that long would be as good later.
    dt_ = std::max(dt, tried < dt_ ? dt_ : 0.0);
    take(x, slope, last ? options_.longestTime : time);
  }

  void take(const State& x, const State& slope, double time) {
    const Vec3 from = toVector(x_), to = toVector(x);
    length_ += (to - from).norm();
    // Chords are shorter than the curve; what is left below rounding counts as reached.
    if (options_.longest - length_ < options_.tolerance) length_ = options_.longest;
    x_ = x;
    slope_ = slope;
    time_ = time;
    const Vec3& seed = line_.points.front().position;
    if (options_.closing > 0) {
      if (left_ && distance(seed, from, to) < options_.closing) closed_ = true;
      if ((to - seed).norm() > kLeaving * options_.closing) left_ = true;
    }
    store();
  }

  void store() {
    line_.points.push_back({toVector(x_), direction_ * toVector(slope_), direction_ * time_});
  }

  const VelocityFunction& velocity_;
  const StreamlineOptions& options_;
  const int direction_;
  Controlled stepper_;
  Streamline line_;
  State x_{}, slope_{};
  double time_ = 0, length_ = 0, dt_ = HUGE_VAL;
  bool left_ = false, closed_ = false, atBoundary_ = false;
};

}  // namespace

double Streamline::length() const {
  double sum = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    sum += (points[k].position - points[k - 1].position).norm();
  }
  return sum;
}

Streamline traceStreamline(const VelocityFunction& velocity, const Vec3& seed,
                           const StreamlineOptions& options, int direction) {
  return Tracer(velocity, options, direction).run(seed);
}

Streamline traceBothWays(const VelocityFunction& velocity, const Vec3& seed,
                         const StreamlineOptions& options) {
  Streamline line = traceStreamline(velocity, seed, options, 1);
  if (line.points.empty()) return line;
  if (line.last == StreamlineEnd::Closed) {
    line.first = StreamlineEnd::Closed;
    return line;
  }
  Streamline back = traceStreamline(velocity, seed, options, -1);
  std::reverse(back.points.begin(), back.points.end());
  back.points.pop_back();
  line.seed = back.points.size();
  line.first = back.last;
  line.points.insert(line.points.begin(), back.points.begin(), back.points.end());
  return line;
}

}  // namespace octet
