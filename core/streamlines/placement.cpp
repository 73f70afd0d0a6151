// SPDX-License-Identifier: Apache-2.0
#include "placement.h"

#include <algorithm>
#include <unordered_map>

#include "../base/reported_loop.h"

namespace octet {
namespace {

/// Candidates per point wanted, before the domain counts as full.
constexpr std::size_t kCandidates = 60;
/// Lines traced at once; a fixed number, so that the result is.
constexpr std::size_t kBatch = 16;

/// The digits of n in a base, mirrored at the point: van der Corput's sequence.
double radicalInverse(std::size_t n, int base) {
  double result = 0, digit = 1;
  for (; n > 0; n /= static_cast<std::size_t>(base)) {
    digit /= base;
    result += digit * static_cast<double>(n % static_cast<std::size_t>(base));
  }
  return result;
}

/// Points by the cubes they lie in: is any of them near?
class Neighbourhood {
 public:
  explicit Neighbourhood(double distance) : distance_(distance) {}

  void add(const Vec3& p) {
    if (distance_ > 0) cubes_[key(cube(p))].push_back(p);
  }
  bool anyNear(const Vec3& p) const {
    if (!(distance_ > 0)) return false;
    const std::array<std::int64_t, 3> at = cube(p);
    for (int n = 0; n < 27; ++n) {
      const auto found =
          cubes_.find(key({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}));
      if (found == cubes_.end()) continue;
      for (const Vec3& q : found->second) {
        if ((p - q).norm() < distance_) return true;
      }
    }
    return false;
  }

 private:
  std::array<std::int64_t, 3> cube(const Vec3& p) const {
    std::array<std::int64_t, 3> result;
    for (int k = 0; k < 3; ++k) {
      result[k] = static_cast<std::int64_t>(std::floor(p[k] / distance_));
    }
    return result;
  }
  /// Cubes that share a key only cost time.
  static std::uint64_t key(const std::array<std::int64_t, 3>& at) {
    std::uint64_t result = 0;
    for (const std::int64_t k : at) {
      result = (result ^ static_cast<std::uint64_t>(k)) * 0x9e3779b97f4a7c15u;
      result ^= result >> 29;
    }
    return result;
  }

  double distance_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cubes_;
};

/// Adds a line, its points no further apart than the distance that matters.
void addLine(const Streamline& line, double spacing, Neighbourhood* lines) {
  for (std::size_t k = 0; k < line.points.size(); ++k) {
    const Vec3& to = line.points[k].position;
    if (k > 0) {
      const Vec3& from = line.points[k - 1].position;
      const int parts = static_cast<int>(std::min((to - from).norm() / spacing, 1e4));
      for (int i = 1; i <= parts; ++i) lines->add(from + (to - from) * i / (parts + 1));
    }
    lines->add(to);
  }
}

}  // namespace

std::vector<Vec3> haltonPoints(const Box& box, std::size_t count, std::size_t first) {
  std::vector<Vec3> result;
  if (box.empty()) return result;
  result.reserve(count);
  for (std::size_t k = first; k < first + count; ++k) {
    const Vec3 unit(radicalInverse(k + 1, 2), radicalInverse(k + 1, 3), radicalInverse(k + 1, 5));
    result.push_back(box.min + unit.cwiseProduct(box.size()));
  }
  return result;
}

std::vector<Vec3> spacedPoints(const std::function<bool(const Vec3&)>& inside, const Box& box,
                               std::size_t count, double distance) {
  std::vector<Vec3> result;
  Neighbourhood taken(distance);
  for (const Vec3& p : haltonPoints(box, count * kCandidates)) {
    if (result.size() == count) break;
    if (taken.anyNear(p) || !inside(p)) continue;
    taken.add(p);
    result.push_back(p);
  }
  return result;
}

std::vector<Streamline> placeStreamlines(const VelocityFunction& velocity, const Box& box,
                                         const PlacementOptions& options, const Context& context) {
  std::vector<Streamline> result;
  Neighbourhood taken(options.separation);
  const std::vector<Vec3> candidates = haltonPoints(box, options.count * kCandidates);
  std::size_t next = 0;
  while (result.size() < options.count && next < candidates.size()) {
    context.report({"streamlines", result.size(), options.count, "lines"});
    std::vector<Vec3> seeds;
    for (; next < candidates.size() && seeds.size() < kBatch; ++next) {
      Vec3 unused;
      const Vec3& p = candidates[next];
      if (!taken.anyNear(p) && velocity(p, &unused)) seeds.push_back(p);
    }
    std::vector<Streamline> batch(seeds.size());
    parallelFor<std::size_t>(
        seeds.size(),
        [&](std::size_t k) { batch[k] = traceBothWays(velocity, seeds[k], options.lines); },
        context, 1);
    for (std::size_t k = 0; k < batch.size() && result.size() < options.count; ++k) {
      if (taken.anyNear(seeds[k]) || batch[k].length() < options.shortest) continue;
      addLine(batch[k], options.separation / 2, &taken);
      result.push_back(std::move(batch[k]));
    }
  }
  context.report({"streamlines", options.count, options.count, "lines"});
  return result;
}

}  // namespace octet
