// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../forms/cochain.h"
#include "virtual_layer.h"

namespace octet {

/// @brief Continues forms from a mesh to the virtual layer around it (thesis 5.5).
///
/// The thesis copies a coefficient from the parallel real simplex. Copies alone do not fit
/// together: a closed form would get a virtual part that is not closed, and subdivision would carry
/// the difference inside. Here every virtual simplex s reads a chain E(s) of real ones, with
///     boundary of E(s) = E of the boundary of s,
/// so that continuing commutes with d: what is curl-free or divergence-free stays so. Constant
/// gradients and fluxes are continued exactly, on every mesh. Of all such chains it is the one
/// nearest to the copy, on a lattice the mean of the nearest parallel simplices, elsewhere nothing.
/// Around a void of the mesh a cell's facets have to agree on more than their boundaries (voids.h).
///
/// @note Where a virtual layer fills a gap of the mesh, as cells of the lattice do in a gap one
/// cell
///       wide, a form that circulates around the gap or flows out of it has no closed continuation;
///       `exact()` is then false and the nearest one is taken.
class Extension {
 public:
  /// @param expanded  built from the layer's mesh
  Extension(const ControlMesh& mesh, const VirtualLayer& layer, const ControlMesh& expanded);

  template <int K>
  Cochain<K> apply(const Cochain<K>& form) const;

  bool exact() const { return exact_; }
  /// The real simplex' number in the expanded mesh.
  template <int K>
  const std::vector<Index>& embedding() const {
    return embedding_[K];
  }

 private:
  class Builder;
  std::shared_ptr<const Complex> expanded_;
  std::vector<Index> embedding_[4];
  /// Per degree: virtual simplices of the expanded mesh and the chains they read.
  std::vector<std::pair<Index, SparseChain>> chains_[4];
  bool exact_ = true;
};

}  // namespace octet
