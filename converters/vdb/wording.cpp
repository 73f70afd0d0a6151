// SPDX-License-Identifier: Apache-2.0
#include "wording.h"

#include <cstdarg>
#include <cstdio>

namespace octet {
namespace {

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[400];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string at(const Vec3& p) { return format("(%.4g, %.4g, %.4g)", p[0], p[1], p[2]); }

/// What there is to say of each reason.
struct Reason {
  const char* name;
  std::string words;
};

Reason told(const NotClosed& r) {
  return {"not_closed", format("not closed: %.4g, or %.3g of the largest coefficient, %s ",
                               r.largest, r.relative, r.degree == 2 ? "leaves" : "runs around") +
                            r.simplex + " at " + at(r.centre)};
}

Reason told(const LeavesVoid& r) {
  std::string text;
  for (const LeavesVoid::NetFlux& net : r.fluxes) {
    text += format("%sa net flux of %.4g leaves through the boundary near ",
                   text.empty() ? "" : ", ", net.flux) +
            at(net.near);
  }
  return {"leaves_void", text + (text.empty() ? "" : ": ") +
                             "the flow has no vector potential: it leaves a void of the domain"};
}

Reason told(const AroundHandle&) {
  return {"around_handle",
          "the flow circulates through a handle of the domain; voxels cut by walls are left out"};
}

Reason told(const Projected& r) {
  return {"projected", "projected: changed by " + format("%.3g", 100 * r.changed) +
                           " % of its norm; was " + told(r.was).words};
}

Reason told(const VoxelsUnlikeEdges& r) {
  return {"voxels_unlike_edges",
          format("voxels are %.2g fine edges: circulations are as accurate from %.2g to %.2g",
                 r.voxelsPerEdge, r.finest, r.coarsest)};
}

Reason told(const MethodLoses& r) { return {"method_loses", r.what}; }

Reason told(const NoRefinedPotential&) {
  return {"no_refined_potential", "sampled, as no refined potential has its derivative"};
}

Reason toldOf(const BakeReason& reason) {
  return std::visit([](const auto& r) { return told(r); }, reason);
}

}  // namespace

std::string words(const BakeReason& reason) { return toldOf(reason).words; }

std::string words(const std::vector<BakeReason>& reasons) {
  std::string text;
  for (const BakeReason& reason : reasons) text += (text.empty() ? "" : "; ") + words(reason);
  return text;
}

const char* reasonName(const BakeReason& reason) { return toldOf(reason).name; }

const char* methodName(GridMethod method) {
  switch (method) {
    case GridMethod::Samples:
      return "samples";
    case GridMethod::Circulations:
      return "circulations";
    case GridMethod::Differences:
      return "differences";
    case GridMethod::None:
      break;
  }
  return "";
}

std::string boundaryWord(const std::string& rule, BoundaryMode mode) {
  if (!rule.empty()) return rule;
  return mode == BoundaryMode::Walls ? "walls" : "open";
}

const char* wallSurfaceWord(BoundaryRows rows) {
  return rows == BoundaryRows::Loop ? "loop" : "smooth";
}

}  // namespace octet
