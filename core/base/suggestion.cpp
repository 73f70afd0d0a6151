// SPDX-License-Identifier: Apache-2.0
#include "suggestion.h"

#include <algorithm>

namespace octet {
namespace {

/// The fewest letters to change, add, take away or swap with the next one.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, row(b.size() + 1), next(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        next[j] = std::min(next[j], before[j - 2] + 1);
      }
    }
    before = row;
    row.swap(next);
  }
  return row[b.size()];
}

/// Of short names fewer letters may differ: "uv" is not "vel".
std::size_t mostChanges(const std::string& name) {
  return std::min<std::size_t>(3, name.size() / 3);
}

}  // namespace

std::string nearestName(const std::string& wanted, const std::vector<std::string>& names) {
  std::string nearest;
  std::size_t least = mostChanges(wanted) + 1;
  for (const std::string& name : names) {
    const std::size_t changes = distance(wanted, name);
    if (changes >= least) continue;
    least = changes;
    nearest = name;
  }
  return nearest;
}

std::string didYouMean(const std::string& wanted, const std::vector<std::string>& names) {
  const std::string nearest = nearestName(wanted, names);
  return nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?";
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace octet
