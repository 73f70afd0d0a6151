// SPDX-License-Identifier: Apache-2.0
#include "influence.h"

#include <tbb/enumerable_thread_specific.h>

#include "../base/reported_loop.h"
#include "../base/sort_unique.h"

namespace octet {
namespace {

/// Coefficients without relations among them, so that what they refine to is 0 only where it is so
/// for all: fractional parts of multiples of the golden ratio.
template <int K>
Cochain<K> genericForm(const Complex& complex, const std::vector<std::uint8_t>& zero) {
  constexpr double kGoldenRatio = 0.61803398874989485;
  Cochain<K> form(complex);
  for (Index k = 0; k < form.size(); ++k) {
    const double x = kGoldenRatio * (k + 1);
    if (!zero[k]) form[k] = 0.5 + (x - std::floor(x));
  }
  return form;
}

}  // namespace

template <int K>
Influence<K>::Influence(const Refiner& refiner, const Limit& limit, BoundaryMode mode,
                        const std::vector<std::uint8_t>& zero, const Context& context)
    : limit_(limit),
      controlCount_(refiner.complex(0).count(K)),
      locator_(refiner.sharedComplex(refiner.levels()), limit.positions()),
      adjoint_(refiner, mode),
      closed_(limit.closedWalls<K>(
          refiner.refine(genericForm<K>(refiner.complex(0), zero), mode, context), mode)) {}

/// The limit vectors at vertices of the finest level, over control coefficients.
template <int K>
std::vector<SparseRow> Influence<K>::vertexRows(const std::vector<Index>& vertices,
                                                const Context& context) const {
  std::vector<SparseRow> rows(3 * vertices.size());
  parallelFor<std::size_t>(
      vertices.size(),
      [&](std::size_t k) {
        auto xyz = limit_.vectorRows<K>(vertices[k], closed_[vertices[k]]);
        for (std::size_t axis = 0; axis < 3; ++axis) rows[3 * k + axis] = std::move(xyz[axis]);
      },
      context, 64);
  return adjoint_.pullBack(std::move(rows), context);
}

template <int K>
InfluenceRows Influence<K>::at(const std::vector<Vec3>& points, const Context& context) const {
  InfluenceRows result;
  result.rows.resize(3 * points.size());
  result.inside.resize(points.size());
  std::vector<VertexWeights> where(points.size());
  parallelFor<std::size_t>(
      points.size(),
      [&](std::size_t k) { result.inside[k] = locator_.locate(points[k], &where[k]); }, context,
      64);
  // Points share vertices: each is pulled back once.
  std::vector<Index> vertices;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!result.inside[k]) continue;
    vertices.insert(vertices.end(), where[k].vertices.begin(),
                    where[k].vertices.begin() + where[k].count);
  }
  sortUnique(&vertices);
  const std::vector<SparseRow> rows = vertexRows(vertices, context);
  tbb::enumerable_thread_specific<RowSum> sums([&] { return RowSum(controlCount_); });
  parallelFor<std::size_t>(
      3 * points.size(),
      [&](std::size_t r) {
        if (!result.inside[r / 3]) return;
        RowSum& sum = sums.local();
        const VertexWeights& at = where[r / 3];
        for (int i = 0; i < at.count; ++i) {
          const auto place = std::lower_bound(vertices.begin(), vertices.end(), at.vertices[i]);
          const std::size_t vertex = static_cast<std::size_t>(place - vertices.begin());
          const SparseRow& row = rows[3 * vertex + r % 3];
          for (std::size_t j = 0; j < row.size(); ++j) {
            sum.add(row.index[j], at.weights[i] * row.weight[j]);
          }
        }
        result.rows[r] = sum.take();
      },
      context, 64);
  return result;
}

template class Influence<1>;
template class Influence<2>;

}  // namespace octet
