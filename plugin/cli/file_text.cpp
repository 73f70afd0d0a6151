// SPDX-License-Identifier: Apache-2.0
#include "file_text.h"

#include <cstdio>

#include <octet/converters/vdb/wording.h>

#include "certificate_text.h"
#include "console.h"

namespace octet::cli {
namespace {

nlohmann::ordered_json toJson(const VdbGridInfo& grid) {
  nlohmann::ordered_json result = {{"name", grid.name},
                                   {"type", grid.type},
                                   {"class", grid.gridClass},
                                   {"vector_type", grid.vectorType},
                                   {"voxel_size", grid.voxelSize},
                                   {"active_voxels", grid.activeVoxels},
                                   {"leaves", grid.leaves},
                                   {"index_min", grid.indexMin},
                                   {"index_max", grid.indexMax},
                                   {"min", grid.min},
                                   {"max", grid.max},
                                   {"half", grid.half}};
  if (grid.method != GridMethod::None) {
    result["method"] = methodName(grid.method);
    result["sampled_voxels"] = grid.sampledVoxels;
  }
  if (!grid.reasons.empty()) result["note"] = words(grid.reasons);
  if (grid.certificate) result["certificate"] = cli::toJson(*grid.certificate);
  return result;
}

/// Of a grid of another method: "", or how many of its voxels are sampled.
std::string shareOfSamples(const VdbGridInfo& grid) {
  if (grid.sampledVoxels == 0 || grid.method == GridMethod::Samples) return "";
  return ", samples in " + percent(grid.sampledVoxels, grid.activeVoxels) +
         " of the voxels, near the boundary";
}

}  // namespace

nlohmann::ordered_json toJson(const BakedFile& file) {
  nlohmann::ordered_json entry = {{"path", file.path}};
  if (file.frame) entry["frame"] = *file.frame;
  if (file.skipped) entry["skipped"] = true;
  entry["grids"] = nlohmann::ordered_json::array();
  for (const VdbGridInfo& grid : file.grids) entry["grids"].push_back(toJson(grid));
  return entry;
}

void print(const BakedFile& file) {
  std::printf("%s%s\n", file.path.c_str(), file.skipped ? kSkipped : "");
  for (const VdbGridInfo& grid : file.grids) {
    std::printf("  %s  %s%s, %s active voxels, %s %.4g to %.4g\n", grid.name.c_str(),
                grid.type.c_str(), grid.half ? " (half)" : "",
                grouped(static_cast<std::int64_t>(grid.activeVoxels)).c_str(),
                grid.vectorType.empty() ? "value" : "length", grid.min, grid.max);
    if (grid.method != GridMethod::None) {
      std::printf("    from %s%s%s%s\n", methodName(grid.method), shareOfSamples(grid).c_str(),
                  grid.reasons.empty() ? "" : "; ", words(grid.reasons).c_str());
    }
    if (grid.certificate) printCertificate(*grid.certificate, "    ");
  }
}

}  // namespace octet::cli
