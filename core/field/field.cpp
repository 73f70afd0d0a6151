// SPDX-License-Identifier: Apache-2.0
#include "field.h"

#include "../base/reported_loop.h"
#include "../topology/domain_box.h"
#include "vertex_field.h"
#include "whitney.h"

namespace octet {
namespace {

/// Limit values as single-component vectors.
Array<Piece<1>::Value> asComponents(const Array<double>& values) {
  Array<Piece<1>::Value> result(values.size());
  parallelFor<std::size_t>(values.size(), [&](std::size_t k) { result[k][0] = values[k]; });
  return result;
}

}  // namespace

template <int C>
Field<C>::Field(std::shared_ptr<const PieceSource<C>> source) : state_(std::make_shared<State>()) {
  state_->bounds = domainBox(source->complex(), source->positions());
  state_->source = std::move(source);
}

template <int C>
bool Field<C>::sample(const Vec3& point, Value* value) const {
  State& state = *state_;
  const PieceSource<C>& source = *state.source;
  std::call_once(state.once, [&] {
    state.bins = BoxBins(source.complex().cellCount(), [&](Index k) { return source.cellBox(k); });
  });
  // The piece that holds the point best: exactly one, except on facets between pieces.
  const typename PieceSource<C>::Filter wanted = [&](const Box& box) {
    const Vec3 margin = kSharedFacetTolerance * box.size();
    return Box{box.min - margin, box.max + margin}.contains(point);
  };
  bool found = false;
  const typename PieceSource<C>::Sink sink = [&](const Piece<C>& piece) {
    if (found) return;
    const Barycentric lambda(piece.points);
    if (!lambda.finite()) return;
    double weights[4];
    for (int i = 0; i < 4; ++i) {
      weights[i] = lambda.gradients[i].dot(point - lambda.origin) + (i == 0 ? 1 : 0);
      if (weights[i] < -kSharedFacetTolerance) return;
    }
    found = true;
    value->setZero();
    for (int i = 0; i < 4; ++i) *value += weights[i] * piece.values[i];
  };
  state.bins.visitAt(point, [&](Index cell) {
    source.visitPieces(cell, wanted, sink);
    return found;
  });
  return found;
}

template <int C>
void Field<C>::sample(const Vec3* points, std::size_t count, Value* values, std::uint8_t* inside,
                      const Context& context) const {
  parallelFor<std::size_t>(
      count,
      [&](std::size_t k) {
        values[k].setZero();
        inside[k] = sample(points[k], &values[k]);
      },
      context, 256);
}

template class Field<1>;
template class Field<3>;

template <int K>
Field<kComponents<K>> makeField(const Refiner& refiner, const Limit& limit, Cochain<K> form,
                                BoundaryMode mode, Reconstruction reconstruction,
                                const Context& context) {
  constexpr int C = kComponents<K>;
  const auto complex = refiner.sharedComplex(refiner.levels());
  form.checkOn(*complex);
  if (reconstruction == Reconstruction::Whitney) {
    return Field<C>(std::make_shared<Whitney<K>>(complex, refiner.positions(refiner.levels()),
                                                 std::move(form), refiner.zeta()));
  }
  Array<typename Piece<C>::Value> values;
  if constexpr (K == 0) values = asComponents(limit.values(form, context));
  if constexpr (K == 1 || K == 2) values = limit.vectors(form, mode, context);
  if constexpr (K == 3) values = asComponents(limit.densities(form, context));
  return Field<C>(std::make_shared<VertexField<C>>(complex, limit.positions(), std::move(values)));
}

template <int K>
Field<kComponents<K>> makeField(const Subdivision& subdivision, const Cochain<K>& control,
                                BoundaryMode mode, Reconstruction reconstruction,
                                const Context& context) {
  constexpr int C = kComponents<K>;
  const auto complex = subdivision.finest();
  if (reconstruction == Reconstruction::Whitney || !subdivision.hasLimits()) {
    return Field<C>(std::make_shared<Whitney<K>>(
        complex, subdivision.positions(subdivision.levels()),
        subdivision.refine(control, mode, context), subdivision.zeta()));
  }
  Array<typename Piece<C>::Value> values;
  if constexpr (K == 0) values = asComponents(subdivision.limitValues(control, mode, context));
  if constexpr (K == 1 || K == 2) values = subdivision.limitVectors(control, mode, context);
  if constexpr (K == 3) values = asComponents(subdivision.limitDensities(control, mode, context));
  return Field<C>(std::make_shared<VertexField<C>>(complex, subdivision.limitPositions(context),
                                                   std::move(values)));
}

template Field<1> makeField(const Refiner&, const Limit&, Cochain<0>, BoundaryMode, Reconstruction,
                            const Context&);
template Field<3> makeField(const Refiner&, const Limit&, Cochain<1>, BoundaryMode, Reconstruction,
                            const Context&);
template Field<3> makeField(const Refiner&, const Limit&, Cochain<2>, BoundaryMode, Reconstruction,
                            const Context&);
template Field<1> makeField(const Refiner&, const Limit&, Cochain<3>, BoundaryMode, Reconstruction,
                            const Context&);
template Field<1> makeField(const Subdivision&, const Cochain<0>&, BoundaryMode, Reconstruction,
                            const Context&);
template Field<3> makeField(const Subdivision&, const Cochain<1>&, BoundaryMode, Reconstruction,
                            const Context&);
template Field<3> makeField(const Subdivision&, const Cochain<2>&, BoundaryMode, Reconstruction,
                            const Context&);
template Field<1> makeField(const Subdivision&, const Cochain<3>&, BoundaryMode, Reconstruction,
                            const Context&);

}  // namespace octet
