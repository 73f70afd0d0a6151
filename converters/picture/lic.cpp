// SPDX-License-Identifier: Apache-2.0
#include "lic.h"

#include <algorithm>
#include <cmath>

#include <octet/core/base/numbers.h>
#include <octet/core/base/reported_loop.h>

namespace octet {
namespace {

/// Step along a line, in pixels.
constexpr double kStep = 1;
/// Contrast: this many standard deviations around the mean fill the range.
constexpr double kDeviations = 2.2;
/// Slower than this part of the fastest is rounding.
constexpr double kStill = 1e-9;
constexpr int kBand = 32;

/// A number in [0, 1) that looks random (the finaliser of SplitMix64).
float noise(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return static_cast<float>((x ^ x >> 31) >> 40) / static_cast<float>(1 << 24);
}

/// Directions in the picture's plane, in pixels, between pixel centres bilinear.
class Directions {
 public:
  explicit Directions(const Slice& slice) : slice_(slice) {
    const SliceGrid& g = slice.grid;
    flow_.resize(slice.inside.size());
    for (std::size_t k = 0; k < flow_.size(); ++k) {
      const double* v = &slice.values[3 * k];
      flow_[k] = {v[g.rightAxis()], -v[g.upAxis()]};
      still_ = std::max(still_, kStill * flow_[k].norm());
    }
  }

  /// Does a pixel's centre lie in the domain, and is there a flow?
  bool flows(std::size_t pixel) const {
    return slice_.inside[pixel] && flow_[pixel].norm() > still_;
  }

  /// Unit vector at a place; false outside and where nothing flows.
  bool at(const Eigen::Vector2d& p, Eigen::Vector2d* direction) const {
    const SliceGrid& g = slice_.grid;
    if (!(p[0] >= 0 && p[1] >= 0 && p[0] < g.width && p[1] < g.height)) return false;
    if (!slice_.isInside(static_cast<int>(p[0]), static_cast<int>(p[1]))) return false;
    const double x = p[0] - 0.5, y = p[1] - 0.5;
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    Eigen::Vector2d sum(0, 0);
    for (int corner = 0; corner < 4; ++corner) {
      const int a = std::clamp(i + (corner & 1), 0, g.width - 1);
      const int b = std::clamp(j + (corner >> 1), 0, g.height - 1);
      const double wx = corner & 1 ? x - i : 1 - x + i, wy = corner >> 1 ? y - j : 1 - y + j;
      sum += wx * wy * flow_[static_cast<std::size_t>(b) * g.width + a];
    }
    const double length = sum.norm();
    if (!(length > still_)) return false;
    *direction = sum / length;
    return true;
  }

 private:
  const Slice& slice_;
  std::vector<Eigen::Vector2d> flow_;
  double still_ = 0;
};

/// The Hann-weighted mean of a texture along the line through a pixel's centre.
float convolve(const Directions& directions, const std::vector<float>& texture,
               const SliceGrid& grid, int x, int y, double reach) {
  const auto value = [&](const Eigen::Vector2d& p) {
    return texture[static_cast<std::size_t>(p[1]) * grid.width + static_cast<std::size_t>(p[0])];
  };
  const Eigen::Vector2d centre(x + 0.5, y + 0.5);
  double sum = value(centre), weights = 1;
  for (const double side : {kStep, -kStep}) {
    Eigen::Vector2d p = centre, d, between;
    if (!directions.at(p, &d)) break;
    for (double s = kStep; s < reach; s += kStep) {
      // Midpoint rule.
      if (!directions.at(p + side / 2 * d, &between)) break;
      const Eigen::Vector2d next = p + side * between;
      if (!directions.at(next, &d)) break;
      p = next;
      const double weight = 0.5 + 0.5 * std::cos(kPi * s / reach);
      sum += weight * value(p);
      weights += weight;
    }
  }
  return static_cast<float>(sum / weights);
}

/// Shifts and scales the pixels where something flows to mean 1/2 and full contrast.
void stretch(const Directions& directions, std::vector<float>* texture) {
  double sum = 0, squares = 0, count = 0;
  for (std::size_t k = 0; k < texture->size(); ++k) {
    if (!directions.flows(k)) continue;
    const double t = (*texture)[k];
    sum += t;
    squares += t * t;
    ++count;
  }
  if (count == 0) return;
  const double mean = sum / count;
  const double deviation = std::sqrt(std::max(squares / count - mean * mean, 1e-12));
  for (std::size_t k = 0; k < texture->size(); ++k) {
    const double t = 0.5 + ((*texture)[k] - mean) / (2 * kDeviations * deviation);
    (*texture)[k] = directions.flows(k) ? static_cast<float>(std::clamp(t, 0.0, 1.0)) : 0.5f;
  }
}

}  // namespace

std::vector<float> lineIntegralConvolution(const Slice& slice, double reach,
                                           const Context& context) {
  const SliceGrid& grid = slice.grid;
  const Directions directions(slice);
  std::vector<float> texture(slice.inside.size());
  for (std::size_t k = 0; k < texture.size(); ++k) texture[k] = noise(k);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<float> result(texture.size(), 0.5f);
    for (int first = 0; first < grid.height; first += kBand) {
      context.report({"convolve", static_cast<std::size_t>(pass * grid.height + first),
                      static_cast<std::size_t>(2 * grid.height), "rows"});
      const int rows = std::min(kBand, grid.height - first);
      parallelFor<int>(
          rows * grid.width,
          [&](int k) {
            const int x = k % grid.width, y = first + k / grid.width;
            const std::size_t at = static_cast<std::size_t>(y) * grid.width + x;
            if (directions.flows(at)) result[at] = convolve(directions, texture, grid, x, y, reach);
          },
          context, 256);
    }
    stretch(directions, &result);
    texture = std::move(result);
  }
  return texture;
}

}  // namespace octet
