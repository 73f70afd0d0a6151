// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "../forms/cochain.h"

namespace octet {

/// @brief Where the simplices of a mesh are in a larger one that contains it, level by level:
/// children are numbered in closed form, so the places of a level give those of the next.
/// Orientations agree at all levels when they do on the control meshes.
struct RealPart {
  std::vector<Index> places[4];  ///< by degree: number in the larger mesh

  /// The places one level finer.
  static RealPart child(const RealPart& coarse, const Complex& own, const Complex& larger);

  template <int K>
  Cochain<K> restrict(const Cochain<K>& form) const {
    Cochain<K> result(Array<double>(places[K].size()));
    for (std::size_t s = 0; s < places[K].size(); ++s) {
      result[static_cast<Index>(s)] = form[places[K][s]];
    }
    return result;
  }
  template <typename T>
  Array<T> ofVertices(const Array<T>& values) const {
    Array<T> result;
    result.reserve(places[0].size());
    for (const Index v : places[0]) result.push_back(values[v]);
    return result;
  }
};

}  // namespace octet
