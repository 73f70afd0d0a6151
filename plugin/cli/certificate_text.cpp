// SPDX-License-Identifier: Apache-2.0
#include "certificate_text.h"

#include <cstdio>

#include "console.h"

namespace octet::cli {

nlohmann::ordered_json toJson(const Certificate& c) {
  return {{"scheme", c.scheme},
          {"active_voxels", c.activeVoxels},
          {"inside_voxels", c.insideVoxels},
          {"divergence_free_voxels", c.freeVoxels},
          {"divergence_max", c.maxDivergence},
          {"divergence_rms", c.rmsDivergence},
          {"divergence_at", c.at},
          {"curl_max", c.maxCurl},
          {"curl_rms", c.rmsCurl},
          {"speed_min", c.minSpeed},
          {"speed_max", c.maxSpeed},
          {"energy", c.energy},
          {"outflow", c.outflow},
          {"throughflow", c.throughflow},
          {"half", c.half},
          {"partial", c.partial}};
}

void printCertificate(const Certificate& c, const char* indent) {
  std::printf(
      "%sdivergence h/max|v|: max %.2g, rms %.2g (%s, %s of %s voxels inside%s), "
      "rounding in %s\n",
      indent, c.maxDivergence, c.rmsDivergence, c.scheme.c_str(),
      grouped(static_cast<std::int64_t>(c.insideVoxels)).c_str(),
      grouped(static_cast<std::int64_t>(c.activeVoxels)).c_str(), c.half ? "; 16-bit floats" : "",
      percent(c.freeVoxels, c.insideVoxels).c_str());
  if (c.partial) std::printf("%sof this part, where it knows what is around a voxel\n", indent);
  std::printf("%scurl h/max|v|: max %.2g, rms %.2g\n", indent, c.maxCurl, c.rmsCurl);
  std::printf("%sspeed %.4g to %.4g, energy %.4g, outflow %.2g of %.2g through the border\n",
              indent, c.minSpeed, c.maxSpeed, c.energy, c.outflow, c.throughflow);
}

}  // namespace octet::cli
