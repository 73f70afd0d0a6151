// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "piece_source.h"

namespace octet {

/// @brief A continuous field with one value per vertex, linear in tetrahedra; an octahedron is the
/// union of eight around its centroid, which takes the mean of its corners (the 0-form's linear
/// rule, thesis Fig. 2.9). The limit reconstruction is one (limit.h).
template <int C>
class VertexField : public PieceSource<C> {
 public:
  using Value = typename Piece<C>::Value;

  /// @param values  one per vertex of the complex
  VertexField(std::shared_ptr<const Complex> complex, Array<Vec3> positions, Array<Value> values)
      : PieceSource<C>(std::move(complex), std::move(positions)), values_(std::move(values)) {}

  const Array<Value>& values() const { return values_; }

  void visitPieces(Index cell, const typename PieceSource<C>::Filter& wanted,
                   const typename PieceSource<C>::Sink& sink) const override {
    const Complex& c = this->complex();
    const Array<Vec3>& x = this->positions();
    Piece<C> piece;
    if (c.isTet(cell)) {
      for (int i = 0; i < 4; ++i) {
        piece.points[i] = x[c.tets[cell][i]];
        piece.values[i] = values_[c.tets[cell][i]];
      }
      if (wanted(piece.box())) sink(piece);
      return;
    }
    const auto& v = c.octs[cell - c.tetCount()];
    piece.points[3].setZero();
    piece.values[3].setZero();
    for (const Index i : v) {
      piece.points[3] += x[i] / 6;
      piece.values[3] += values_[i] / 6;
    }
    for (const auto& f : Octahedron::facets) {
      for (int k = 0; k < 3; ++k) {
        piece.points[k] = x[v[f[k]]];
        piece.values[k] = values_[v[f[k]]];
      }
      if (wanted(piece.box())) sink(piece);
    }
  }

 private:
  Array<Value> values_;
};

}  // namespace octet
