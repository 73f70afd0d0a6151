// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fit_report.h"
#include "guides.h"

namespace octet {

/// Finds how well guides are followed: fills `guides` and `residual` of the report.
/// @param errors  |v - wanted| per sample
void reportErrors(const Guides& guides, const std::vector<GuideSample>& samples,
                  const std::vector<double>& errors, FitReport* report);

/// Finds which share of points lies farther than `reach` from every sample.
double shareFarFrom(const std::vector<GuideSample>& samples, const Array<Vec3>& points,
                    double reach);

}  // namespace octet
