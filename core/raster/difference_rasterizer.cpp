// SPDX-License-Identifier: Apache-2.0
#include "difference_rasterizer.h"

#include "../base/reported_loop.h"
#include "rasterizer.h"
#include "tile_grid.h"

namespace octet {
namespace {

/// A frame of whose window the tiles beside it are wanted, too.
GridFrame withNeighbours(GridFrame frame) {
  for (int k = 0; k < 3; ++k) {
    --frame.window.min[k];
    ++frame.window.max[k];
  }
  return frame;
}

/// Samples a field into memory; active is what lies inside the domain.
template <int C>
void sampleInto(TileGrid<C>* grid, const Field<C>& field, const GridFrame& frame,
                const std::string& stage, const Context& context) {
  rasterize<C>(
      field.source(), frame, Sampling::Collocated, [&](const Tile<C>& tile) { grid->add(tile); },
      stage, context);
  grid->sort();
}

SampleIndex beside(SampleIndex at, int axis, int by) {
  at[axis] += by;
  return at;
}

/// The value of an active sample.
struct Found {
  bool active = false;
  double value = 0;
};
Found lookUp(const TileGrid<1>& grid, const SampleIndex& at) {
  const Tile<1>* const tile = grid.find(at);
  const int n = placeInTile(at);
  return tile && tile->isActive(n) ? Found{true, tile->values[0][n]} : Found{};
}

/// Values of f one voxel outside: from each neighbour c inside, so that the central difference
/// there is the vector, f(c - e) + 2 h V . e; the mean of them.
class Continued {
 public:
  Continued(const TileGrid<1>& inside, const TileGrid<3>& vectors, double h)
      : inside_(inside), h_(h) {
    for (std::size_t t = 0; t < vectors.tileCount(); ++t) {
      const Tile<3>& tile = vectors.tile(t);
      visitActive(tile, [&](const SampleIndex& c, int n) {
        for (int axis = 0; axis < 3; ++axis) continueAlong(c, axis, tile.values[axis][n]);
      });
    }
  }

  /// @param at  outside, beside a sample inside
  double operator()(const SampleIndex& at) const {
    const Tile<2>* const tile = sums_.find(at);
    const int n = placeInTile(at);
    return tile->values[0][n] / tile->values[1][n];
  }

 private:
  void continueAlong(const SampleIndex& c, int axis, double slope) {
    for (const int side : {-1, 1}) {
      const SampleIndex out = beside(c, axis, side);
      if (lookUp(inside_, out).active) continue;
      const Found back = lookUp(inside_, beside(c, axis, -side));
      const double rise = side * h_ * slope;
      const double value = back.active ? back.value + 2 * rise : lookUp(inside_, c).value + rise;
      Tile<2>& tile = sums_.at(out);
      tile.values[0][placeInTile(out)] += value;
      tile.values[1][placeInTile(out)] += 1;
    }
  }

  const TileGrid<1>& inside_;
  const double h_;
  TileGrid<2> sums_;  // of values, and how many
};

/// f = base + x . vectors / 2 at the samples inside, in place of base.
void addVectors(const TileGrid<3>& vectors, const GridFrame& frame, const Context& context,
                TileGrid<1>* base) {
  const auto addTo = [&](std::size_t t) {
    Tile<1>& tile = base->tile(t);
    const Tile<3>& v = *vectors.find(tile.origin);
    visitActive(tile, [&](const SampleIndex& c, int n) {
      double half = 0;
      for (int k = 0; k < 3; ++k) {
        half += (frame.origin[k] + frame.voxelSize * c[k]) * v.values[k][n] / 2;
      }
      tile.values[0][n] += half;
    });
  };
  parallelFor<std::size_t>(base->tileCount(), addTo, context, 1);
}

}  // namespace

void rasterizeDifferences(const GradientField& field, const GridFrame& frame, Sampling sampling,
                          const TileSink<3>& sink, const std::string& stage,
                          const Context& context) {
  const double h = frame.voxelSize;
  TileGrid<3> vectors;
  TileGrid<1> inside;
  sampleInto(&vectors, field.vectors, withNeighbours(frame), stage, context);
  sampleInto(&inside, field.base, withNeighbours(frame), stage, context);
  addVectors(vectors, frame, context, &inside);
  const Continued outside(inside, vectors, h);
  const auto potential = [&](const SampleIndex& at) {
    const Found found = lookUp(inside, at);
    return found.active ? found.value : outside(at);
  };
  const bool staggered = sampling == Sampling::Staggered;
  const auto difference = [&](std::size_t t) {
    const Tile<1>& f = inside.tile(t);
    if (!frame.window.contains(f.place())) return;
    Tile<3> tile;
    tile.origin = f.origin;
    tile.active = f.active;
    for (auto& component : tile.values) component.fill(0);
    visitActive(f, [&](const SampleIndex& c, int n) {
      for (int axis = 0; axis < 3; ++axis) {
        const double before = potential(beside(c, axis, -1));
        const double after = staggered ? f.values[0][n] : potential(beside(c, axis, 1));
        tile.values[axis][n] = (after - before) / (staggered ? h : 2 * h);
      }
    });
    sink(tile);
  };
  parallelFor<std::size_t>(inside.tileCount(), difference, context, 1);
}

}  // namespace octet
