// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace octet {

/// Sorts a list and drops what stands in it twice.
template <typename List>
void sortUnique(List* list) {
  std::sort(list->begin(), list->end());
  list->erase(std::unique(list->begin(), list->end()), list->end());
}

}  // namespace octet
