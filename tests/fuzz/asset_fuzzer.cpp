// SPDX-License-Identifier: Apache-2.0
// libFuzzer on control assets: asset_fuzzer CORPUS tests/data/malformed tests/data/wellformed
#include "inputs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  octet::fuzz::tryAsset(data, size);
  return 0;
}
