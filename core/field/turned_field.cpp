// SPDX-License-Identifier: Apache-2.0
#include "turned_field.h"

#include "../base/parallel.h"

namespace octet {
namespace {

/// Positions and values of pieces turned on the way.
template <int C>
class TurnedSource : public PieceSource<C> {
 public:
  TurnedSource(const Field<C>& field, std::shared_ptr<const Complex> complex, const AxisTurn& turn)
      : PieceSource<C>(std::move(complex), turn(field.source().positions())),
        field_(field),
        turn_(turn) {}

  void visitPieces(Index cell, const typename PieceSource<C>::Filter& wanted,
                   const typename PieceSource<C>::Sink& sink) const override {
    const auto boxWanted = [&](const Box& box) {
      Box turnedBox;
      turnedBox.extend(turn_(box.min));
      turnedBox.extend(turn_(box.max));
      return wanted(turnedBox);
    };
    field_.source().visitPieces(cell, boxWanted, [&](const Piece<C>& piece) {
      Piece<C> result = piece;
      for (int i = 0; i < 4; ++i) {
        result.points[i] = turn_(piece.points[i]);
        if constexpr (C == 3) result.values[i] = turn_(piece.values[i]);
      }
      sink(result);
    });
  }

 private:
  Field<C> field_;
  AxisTurn turn_;
};

}  // namespace

Vec3 AxisTurn::operator()(const Vec3& v) const {
  if (!changes()) return v;
  return from == 'Z' ? Vec3(v[0], v[2], -v[1]) : Vec3(v[0], -v[2], v[1]);
}

Array<Vec3> AxisTurn::operator()(Array<Vec3> vectors) const {
  if (!changes()) return vectors;
  parallelFor<std::size_t>(vectors.size(),
                           [&](std::size_t k) { vectors[k] = (*this)(vectors[k]); });
  return vectors;
}

template <int C>
Field<C> turnedField(const Field<C>& field, std::shared_ptr<const Complex> complex,
                     const AxisTurn& turn) {
  if (!turn.changes()) return field;
  return Field<C>(std::make_shared<TurnedSource<C>>(field, std::move(complex), turn));
}

template Field<1> turnedField(const Field<1>&, std::shared_ptr<const Complex>, const AxisTurn&);
template Field<3> turnedField(const Field<3>&, std::shared_ptr<const Complex>, const AxisTurn&);

}  // namespace octet
