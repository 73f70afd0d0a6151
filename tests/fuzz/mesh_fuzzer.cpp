// SPDX-License-Identifier: Apache-2.0
// libFuzzer on what is done to a mesh before Gmsh sees it: mesh_fuzzer CORPUS tests/data/gmsh
// The first byte chooses the format.
#include "inputs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  octet::fuzz::tryMeshCheck(octet::fuzz::kMeshExtensions[data[0] % 3], data + 1, size - 1);
  return 0;
}
