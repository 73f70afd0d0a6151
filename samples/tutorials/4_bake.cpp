// SPDX-License-Identifier: Apache-2.0
// A bake to OpenVDB with progress, and what OpenVDB's own operators find in it.
// Arguments: samples/box/box.octet.json out.vdb
#include <cstdio>

#include <octet/converters/api.h>
#include <octet/core/api.h>

int main(int, char** argv) {
  const octet::ControlAsset asset = octet::readControlAsset(argv[1]);
  octet::BakeOptions options;
  options.forms = {"velocity"};
  options.resolution = 48;
  options.sampling = octet::Sampling::Staggered;

  // Called from this thread, some times a second; false would stop the bake.
  std::string stage;
  const octet::Context context([&](const octet::ProgressReport& report) {
    if (report.stage != stage && report.stage.rfind("bake", 0) == 0) {
      std::printf("%s\n", report.stage.c_str());
    }
    stage = report.stage;
    return true;
  });
  try {
    const octet::BakeReport report = octet::bake(asset, options, argv[2], context);
    const octet::VdbGridInfo& grid = report.files[0].grids[0];
    std::printf("%s: %llu voxels\n", grid.name.c_str(),
                static_cast<unsigned long long>(grid.activeVoxels));
    std::printf("divergence below 2e-6 of the largest speed, per voxel: %s\n",
                grid.certificate->maxDivergence < 2e-6 ? "yes" : "no");
  } catch (const octet::Error& e) {  // file, place and reason of what is wrong
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
