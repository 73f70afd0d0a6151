// SPDX-License-Identifier: Apache-2.0
// Peak memory of building operators, refining one 2-form and making its limit field, per cell of
// the finest level; of the whole process, which must do nothing else: memory [MESH] [SIZE]
#include <cstdio>
#include <exception>

#include <sys/resource.h>

#include <octet/core/field/field.h>

#include "bench_meshes.h"

namespace octet::bench {
namespace {

double peakBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void measure(const std::string& name, const std::string& sizeName) {
  const ControlMesh mesh = controlMesh(name);
  const Refiner refiner = makeRefiner(mesh, findSize(sizeName).levels);
  const Limit limit(refiner);
  const auto mode = BoundaryMode::Open;
  const auto field = makeField<2>(
      refiner, limit, refiner.refine(testing::randomForm<2>(*mesh.complex(), 1), mode), mode);
  const Index cells = refiner.finest().cellCount();
  std::printf("memory %s/%s %d cells %.1f bytes/cell\n", name.c_str(), sizeName.c_str(), cells,
              peakBytes() / cells);
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) try {
  octet::bench::measure(argc > 1 ? argv[1] : "ball", argc > 2 ? argv[2] : "500k");
} catch (const std::exception& error) {
  std::fprintf(stderr, "memory: %s\n", error.what());
  return 1;
}
