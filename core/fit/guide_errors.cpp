// SPDX-License-Identifier: Apache-2.0
#include "guide_errors.h"

#include <algorithm>
#include <cmath>

#include "../base/parallel.h"

namespace octet {
namespace {

/// Sums over the samples of a guide, or of all, by weight.
struct ErrorSums {
  double length = 0, missed = 0, wanted = 0, worst = 0;

  void add(const GuideSample& sample, double error) {
    length += sample.weight;
    missed += sample.weight * error * error;
    wanted += sample.weight * sample.value.squaredNorm();
    worst = std::max(worst, error);
  }
};

}  // namespace

void reportErrors(const Guides& guides, const std::vector<GuideSample>& samples,
                  const std::vector<double>& errors, FitReport* report) {
  const std::size_t guideCount = guides.curves.size() + guides.vectors.size();
  std::vector<ErrorSums> sums(guideCount);
  ErrorSums all;
  report->guides.resize(guideCount);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    sums[samples[k].guide].add(samples[k], errors[k]);
    all.add(samples[k], errors[k]);
    ++report->guides[samples[k].guide].samples;
  }
  for (std::size_t g = 0; g < guideCount; ++g) {
    GuideReport& guide = report->guides[g];
    guide.name = guideName(guides, g);
    const double speed = std::sqrt(sums[g].wanted / sums[g].length);
    // A guide that wants the field at rest has no size of its own: take all guides'.
    const double unit = speed > 0 ? speed : std::sqrt(all.wanted / all.length);
    guide.residual = unit > 0 ? std::sqrt(sums[g].missed / sums[g].length) / unit : 0;
    guide.worst = unit > 0 ? sums[g].worst / unit : 0;
  }
  report->residual = all.wanted > 0 ? std::sqrt(all.missed / all.wanted) : 0;
}

double shareFarFrom(const std::vector<GuideSample>& samples, const Array<Vec3>& points,
                    double reach) {
  std::vector<std::uint8_t> far(points.size());
  parallelFor<std::size_t>(
      points.size(),
      [&](std::size_t v) {
        far[v] = std::none_of(samples.begin(), samples.end(), [&](const GuideSample& sample) {
          return (sample.point - points[v]).squaredNorm() < reach * reach;
        });
      },
      64);
  return static_cast<double>(std::count(far.begin(), far.end(), 1)) /
         static_cast<double>(far.size());
}

}  // namespace octet
