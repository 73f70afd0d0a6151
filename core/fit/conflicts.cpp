// SPDX-License-Identifier: Apache-2.0
#include "conflicts.h"

#include <algorithm>
#include <map>

#include "../geometry/box_bins.h"

namespace octet {
namespace {

constexpr double kNear = 0.5;      // mean edges
constexpr double kDisagree = 0.5;  // of the greater of two wanted vectors
constexpr double kMissed = 0.2;    // likewise
constexpr double kOtherArc = 2;    // mean edges along a curve: then it is another part of it

}  // namespace

std::vector<GuideConflict> findConflicts(const Guides& guides,
                                         const std::vector<GuideSample>& samples,
                                         const std::vector<double>& errors, double meanEdge) {
  const double near = kNear * meanEdge;
  const BoxBins bins(static_cast<Index>(samples.size()), [&](Index k) {
    const Vec3& p = samples[k].point;
    return Box{p - Vec3::Constant(near), p + Vec3::Constant(near)};
  });
  std::map<std::pair<std::size_t, std::size_t>, GuideConflict> worst;
  for (std::size_t a = 0; a < samples.size(); ++a) {
    bins.visitAt(samples[a].point, [&](Index other) {
      const std::size_t b = static_cast<std::size_t>(other);
      if (b <= a || (samples[a].point - samples[b].point).norm() > near) return false;
      if (samples[a].guide == samples[b].guide &&
          std::abs(samples[a].along - samples[b].along) < kOtherArc * meanEdge) {
        return false;
      }
      const double size = std::max(samples[a].value.norm(), samples[b].value.norm());
      const double disagreement = (samples[a].value - samples[b].value).norm();
      const double missed = std::max(errors[a], errors[b]);
      if (disagreement < kDisagree * size || missed < kMissed * size) return false;
      GuideConflict& conflict = worst[std::minmax(samples[a].guide, samples[b].guide)];
      if (disagreement / size > conflict.disagreement) {
        conflict = {guideName(guides, samples[a].guide), guideName(guides, samples[b].guide),
                    (samples[a].point + samples[b].point) / 2, disagreement / size, missed / size};
      }
      return false;
    });
  }
  std::vector<GuideConflict> result;
  for (auto& [pair, conflict] : worst) result.push_back(std::move(conflict));
  return result;
}

}  // namespace octet
