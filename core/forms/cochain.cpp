// SPDX-License-Identifier: Apache-2.0
#include "cochain.h"

#include <string>

#include "../base/error.h"

namespace octet {

Numbering::Numbering(const Complex& complex) : control(&complex) {
  for (; control->coarse; control = control->coarse.get()) ++level;
}

void checkNumbering(int degree, Index size, const Numbering& own, Index count,
                    const Numbering& wanted) {
  const std::string form = "a form of degree " + std::to_string(degree);
  if (size != count) {
    throw InputError("", form + " on level " + std::to_string(wanted.level) + " has " +
                             std::to_string(count) + " coefficients, not " + std::to_string(size));
  }
  if (!own.control) return;
  if (own.level != wanted.level) {
    throw InputError("", form + " is on level " + std::to_string(own.level) + ", not " +
                             std::to_string(wanted.level));
  }
  if (own.control != wanted.control) throw InputError("", form + " is on another mesh");
}

}  // namespace octet
