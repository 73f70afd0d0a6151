// SPDX-License-Identifier: Apache-2.0
#include "star_limits.h"

namespace octet {

StarLimits::StarLimits(const Complex& complex) : limits_(interiorLimits(complex)) {
  if (limits_.empty()) return;
  stars_.assign(static_cast<std::size_t>(complex.vertexCount()), kNoStar);
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    stars_[limits_[k].vertices[0]] = static_cast<std::uint32_t>(k);
  }
}

}  // namespace octet
