// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <type_traits>

#include "../base/error.h"

namespace octet {

/// Calls `use(integral_constant<int, K>)` with the degree of a form as a constant.
/// @throws InputError when it is none of 0 to 3
template <typename Use>
auto withDegree(int degree, const Use& use) {
  switch (degree) {
    case 0:
      return use(std::integral_constant<int, 0>{});
    case 1:
      return use(std::integral_constant<int, 1>{});
    case 2:
      return use(std::integral_constant<int, 2>{});
    case 3:
      return use(std::integral_constant<int, 3>{});
    default:
      throw InputError("degree", std::to_string(degree) + " is not 0, 1, 2 or 3");
  }
}

}  // namespace octet
