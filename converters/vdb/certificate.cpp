// SPDX-License-Identifier: Apache-2.0
#include "certificate.h"

namespace octet {

std::vector<VdbMetadata> toMetadata(const Certificate& c) {
  std::vector<VdbMetadata> metadata = {
      {"octet_divergence_scheme", c.scheme},
      {"octet_divergence_max", c.maxDivergence},
      {"octet_divergence_rms", c.rmsDivergence},
      {"octet_curl_max", c.maxCurl},
      {"octet_curl_rms", c.rmsCurl},
      {"octet_inside_voxels", static_cast<double>(c.insideVoxels)},
      {"octet_divergence_free_voxels", static_cast<double>(c.freeVoxels)},
      {"octet_speed_max", c.maxSpeed},
      {"octet_energy", c.energy},
      {"octet_outflow", c.outflow},
      {"octet_throughflow", c.throughflow}};
  if (c.partial) metadata.push_back({kPartialMetadata, std::string("partial")});
  return metadata;
}

}  // namespace octet
