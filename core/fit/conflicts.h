// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fit_report.h"
#include "guides.h"

namespace octet {

/// @brief Finds guides that no field of the cage's resolution can follow both: samples of two
/// guides, or of two arcs of one, closer than half a mean edge, whose wanted vectors differ by more
/// than half of the greater, and where at least one is missed by a fifth or more of it. One report
/// per pair of guides, where they disagree most.
/// @param errors  |v - wanted| per sample
std::vector<GuideConflict> findConflicts(const Guides& guides,
                                         const std::vector<GuideSample>& samples,
                                         const std::vector<double>& errors, double meanEdge);

}  // namespace octet
