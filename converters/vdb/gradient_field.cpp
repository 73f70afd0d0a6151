// SPDX-License-Identifier: Apache-2.0
#include "gradient_field.h"

#include <mutex>

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

namespace octet {
namespace {

using openvdb::Coord;
using Scalars = openvdb::DoubleTree;
using Vectors = openvdb::Vec3DTree;

/// A field's samples as a tree, active inside the domain.
template <typename Tree, int C>
Tree sampled(const Field<C>& field, const GridFrame& frame, const std::string& stage,
             const ProgressCallback& progress) {
  using Leaf = typename Tree::LeafNodeType;
  Tree tree{typename Tree::ValueType(0.0)};
  std::mutex mutex;
  const auto sink = [&](const Tile<C>& tile) {
    auto leaf = std::make_unique<Leaf>(Coord(tile.origin[0], tile.origin[1], tile.origin[2]),
                                       typename Tree::ValueType(0.0), false);
    typename Leaf::NodeMaskType mask;
    for (int x = 0; x < 8; ++x) mask.template getWord<openvdb::Index64>(x) = tile.active[x];
    leaf->setValueMask(mask);
    auto* out = leaf->buffer().data();
    for (int n = 0; n < Tile<C>::kSize; ++n) {
      if constexpr (C == 1) {
        out[n] = tile.values[0][n];
      } else {
        out[n] = {tile.values[0][n], tile.values[1][n], tile.values[2][n]};
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    tree.addLeaf(leaf.release());
  };
  rasterize<C>(field.source(), frame, Sampling::Collocated, sink, stage, progress);
  return tree;
}

Coord beside(const Coord& ijk, int axis, int by) {
  Coord result = ijk;
  result[axis] += by;
  return result;
}

/// Values of f one voxel outside: from each neighbour c inside, so that the central difference
/// there is the vector, f(c - e) + 2 h V . e; the mean of them.
Scalars continued(const Scalars& inside, const Vectors& vectors, double h) {
  Scalars sum(0.0), count(0.0);
  openvdb::tree::ValueAccessor<Scalars> addTo(sum), countTo(count);
  openvdb::tree::ValueAccessor<const Scalars> f(inside);
  for (auto it = vectors.cbeginValueOn(); it; ++it) {
    const Coord c = it.getCoord();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        const Coord out = beside(c, axis, side), back = beside(c, axis, -side);
        if (f.isValueOn(out)) continue;
        const double rise = side * h * it.getValue()[axis];
        const double value = f.isValueOn(back) ? f.getValue(back) + 2 * rise : f.getValue(c) + rise;
        addTo.setValue(out, addTo.getValue(out) + value);
        countTo.setValue(out, countTo.getValue(out) + 1);
      }
    }
  }
  for (auto it = sum.beginValueOn(); it; ++it) it.setValue(*it / countTo.getValue(it.getCoord()));
  return sum;
}

}  // namespace

void rasterizeDifferences(const GradientField& field, const GridFrame& frame, Sampling sampling,
                          const std::function<void(const Tile<3>&)>& sink, const std::string& stage,
                          const ProgressCallback& progress) {
  const double h = frame.voxelSize;
  const auto vectors = sampled<Vectors, 3>(field.vectors, frame, stage, progress);
  auto inside = sampled<Scalars, 1>(field.base, frame, stage, progress);
  openvdb::tree::ValueAccessor<const Vectors> vectorAt(vectors);
  for (auto it = inside.beginValueOn(); it; ++it) {
    const Coord c = it.getCoord();
    const openvdb::Vec3d& v = vectorAt.getValue(c);
    double half = 0;
    for (int k = 0; k < 3; ++k) half += (frame.origin[k] + h * c[k]) * v[k] / 2;
    it.setValue(*it + half);
  }
  const Scalars outside = continued(inside, vectors, h);
  openvdb::tree::ValueAccessor<const Scalars> in(inside), out(outside);
  const auto potential = [&](const Coord& c) {
    return in.isValueOn(c) ? in.getValue(c) : out.getValue(c);
  };
  const bool staggered = sampling == Sampling::Staggered;
  Tile<3> tile;
  for (auto leaf = inside.cbeginLeaf(); leaf; ++leaf) {
    tile.active.fill(0);
    for (auto& component : tile.values) component.fill(0);
    for (int k = 0; k < 3; ++k) tile.origin[k] = leaf->origin()[k];
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      const Coord c = it.getCoord();
      const openvdb::Index n = it.pos();
      tile.active[n >> 6] |= std::uint64_t{1} << (n & 63);
      for (int axis = 0; axis < 3; ++axis) {
        const double before = potential(beside(c, axis, -1));
        const double after = staggered ? *it : potential(beside(c, axis, 1));
        tile.values[axis][n] = (after - before) / (staggered ? h : 2 * h);
      }
    }
    sink(tile);
  }
}

}  // namespace octet
