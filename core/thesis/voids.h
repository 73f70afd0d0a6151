// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "virtual_layer.h"

namespace octet {

/// @brief The voids of a mesh: pieces of its boundary that the rest of the mesh encloses, down to
/// the size of a single cell left out, and how closed 2-chains wind around them.
///
/// A closed chain bounds cells of the mesh only if it winds around no void. How often it does is
/// its flux of a unit flow that runs through the mesh from the outside into the void.
class Voids {
 public:
  /// A virtual cell and the facet through which the way leads from it out of the expanded mesh.
  struct Exit {
    Index cell, facet;
  };

  /// @param cells  numbers of the mesh's cells in the expanded mesh
  Voids(const Complex& mesh, const Complex& expanded, const std::vector<Index>& cells);

  int count() const { return static_cast<int>(surfaces_.size()); }
  /// The mesh's facets around a void, pointing into it: it winds around it once.
  const SparseChain& surface(int which) const { return surfaces_[static_cast<std::size_t>(which)]; }
  /// How often a closed chain winds around each.
  std::vector<double> windings(const std::map<Index, double>& chain) const;
  /// Every virtual cell from which a way leads out, before those that the way leads through.
  const std::vector<Exit>& exits() const { return exits_; }

 private:
  class Builder;
  std::vector<SparseChain> surfaces_;
  std::map<Index, std::vector<std::pair<int, double>>> flows_;  // by facet: void, flow to it
  std::vector<Exit> exits_;
};

}  // namespace octet
