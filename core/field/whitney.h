// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../forms/cochain.h"
#include "../rules/linear_rules.h"
#include "piece_source.h"

namespace octet {

/// @brief The Whitney form of a cochain, cell by cell (thesis 3.2, SCHEME.md section 9). In a
/// tetrahedron it is linear; an octahedron has no closed form and is refined by the linear rules
/// until what is asked for lies in tetrahedra. Lowest order, tangential (1-forms) or normal
/// (2-forms) components continuous. Immutable; thread safe.
template <int K>
class Whitney : public PieceSource<kComponents<K>> {
 public:
  static constexpr int C = kComponents<K>;
  using typename PieceSource<C>::Filter;
  using typename PieceSource<C>::Sink;

  /// @param positions  of the complex' vertices; `form` its coefficients
  Whitney(std::shared_ptr<const Complex> complex, Array<Vec3> positions, Cochain<K> form,
          double zeta = kDefaultZeta);

  /// Inside an octahedron goes only as deep as `wanted` asks for.
  void visitPieces(Index cell, const Filter& wanted, const Sink& sink) const override;

 private:
  struct Tables;
  Cochain<K> form_;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace octet
