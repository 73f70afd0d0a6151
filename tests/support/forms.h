// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/forms/cochain.h>

#include "tests/support/meshes.h"

namespace octet::testing {

/// Random coefficients in [-1, 1], the same on every machine.
template <int K>
Cochain<K> randomForm(const Complex& complex, std::uint32_t seed) {
  const auto values = randomValues(complex.count(K), seed);
  return Cochain<K>(Array<double>(values.begin(), values.end()));
}

}  // namespace octet::testing
