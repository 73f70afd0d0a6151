// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <octet/core/base/error.h>

namespace octet::python {

/// The value that a name stands for.
/// @throws InputError listing the names there are
template <typename T>
T choose(const char* argument, const std::string& name,
         const std::vector<std::pair<std::string, T>>& choices) {
  std::string names;
  for (const auto& [known, value] : choices) {
    if (name == known) return value;
    names += (names.empty() ? "" : ", ") + known;
  }
  throw InputError(argument, "\"" + name + "\" is none of " + names);
}

}  // namespace octet::python
