// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "../topology/complex.h"
#include "piece.h"

namespace octet {

/// Number of components of a k-form's proxy field: functions and densities have 1, vectors 3.
template <int K>
inline constexpr int kComponents = K == 1 || K == 2 ? 3 : 1;

/// @brief A piecewise linear field of C components, cell by cell: what point sampling and
/// rasterising read. Immutable; thread safe.
template <int C>
class PieceSource {
 public:
  /// Is anything in this box asked for?
  using Filter = std::function<bool(const Box&)>;
  using Sink = std::function<void(const Piece<C>&)>;

  PieceSource(std::shared_ptr<const Complex> complex, Array<Vec3> positions)
      : complex_(std::move(complex)), positions_(std::move(positions)) {}
  virtual ~PieceSource() = default;

  const Complex& complex() const { return *complex_; }
  /// Vertex positions in world units; pieces fill the cells they span.
  const Array<Vec3>& positions() const { return positions_; }
  Box cellBox(Index cell) const {
    Box box;
    for (int i = 0; i < complex_->cellVertexCount(cell); ++i) {
      box.extend(positions_[complex_->cellVertex(cell, i)]);
    }
    return box;
  }

  /// Calls `sink` for the pieces of a cell whose boxes `wanted` accepts.
  virtual void visitPieces(Index cell, const Filter& wanted, const Sink& sink) const = 0;

 private:
  std::shared_ptr<const Complex> complex_;
  Array<Vec3> positions_;
};

}  // namespace octet
