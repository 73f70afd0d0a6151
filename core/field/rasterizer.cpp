// SPDX-License-Identifier: Apache-2.0
#include "rasterizer.h"

#include <algorithm>
#include <cmath>

#include <tbb/enumerable_thread_specific.h>

#include "../base/parallel.h"

namespace octet {
namespace {

constexpr int kTile = 8;
/// Tiles along a block's edge, unless that makes too many blocks.
constexpr int kBlockTiles = 16;
constexpr std::int64_t kMostBlocks = 1 << 20;
/// Boxes are widened by this many voxels, so that samples on facets are found from both sides.
constexpr double kMargin = 1e-7;
/// Largest grid index in any direction.
constexpr double kLargestIndex = 1 << 30;

using Int = std::int32_t;

/// A range of integer points, both ends included.
struct IndexBox {
  std::array<Int, 3> min, max;
  bool empty() const { return min[0] > max[0] || min[1] > max[1] || min[2] > max[2]; }
};

Int floorDivide(Int a, Int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

/// Draws linear pieces into a tile.
template <int C>
class TilePainter {
 public:
  TilePainter(const GridFrame& frame, Sampling sampling)
      : perVoxel_(1 / frame.voxelSize), origin_(frame.origin), sampling_(sampling) {}

  void begin(const std::array<Int, 3>& origin) {
    tile_.origin = origin;
    for (auto& component : tile_.values) component.fill(0);
    tile_.active.fill(0);
  }

  /// Does a box hold any of the tile's samples?
  bool wants(const Box& box) const {
    const Vec3 first(tile_.origin[0], tile_.origin[1], tile_.origin[2]);
    const Vec3 low = (box.min - origin_) * perVoxel_ - first;
    const Vec3 high = (box.max - origin_) * perVoxel_ - first;
    int from[3], to[3];
    if (sampling_ == Sampling::Collocated) return samplesIn(low, high, from, to);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 shift = 0.5 * Vec3::Unit(axis);
      if (samplesIn(low + shift, high + shift, from, to)) return true;
    }
    return false;
  }

  void paint(const Piece<C>& piece) {
    std::array<Vec3, 4> p;
    const Vec3 first(tile_.origin[0], tile_.origin[1], tile_.origin[2]);
    for (int i = 0; i < 4; ++i) p[i] = (piece.points[i] - origin_) * perVoxel_ - first;
    if (sampling_ == Sampling::Collocated) {
      paintComponents<0, C>(p, piece.values);
      return;
    }
    if constexpr (C == 3) {
      // The sample of component c at index i lies at i - 1/2 along c.
      paintShifted<0>(p, piece.values);
      paintShifted<1>(p, piece.values);
      paintShifted<2>(p, piece.values);
    }
  }

  const Tile<C>& tile() const { return tile_; }
  bool empty() const {
    return std::all_of(tile_.active.begin(), tile_.active.end(), [](auto w) { return w == 0; });
  }

 private:
  using Values = std::array<typename Piece<C>::Value, 4>;

  /// The tile's integer points in a box, in coordinates from its first sample.
  static bool samplesIn(const Vec3& low, const Vec3& high, int* from, int* to) {
    for (int k = 0; k < 3; ++k) {
      if (!(high[k] >= -kMargin && low[k] <= kTile - 1 + kMargin)) return false;
      from[k] = static_cast<int>(std::ceil(std::max(low[k] - kMargin, 0.0)));
      to[k] = static_cast<int>(std::floor(std::min(high[k] + kMargin, kTile - 1.0)));
      if (from[k] > to[k]) return false;
    }
    return true;
  }

  template <int Axis>
  void paintShifted(std::array<Vec3, 4> p, const Values& values) {
    for (Vec3& x : p) x[Axis] += 0.5;
    paintComponents<Axis, Axis + 1>(p, values);
  }

  /// Components First..Last-1 at the tile's integer points inside the tetrahedron `p`.
  template <int First, int Last>
  void paintComponents(const std::array<Vec3, 4>& p, const Values& values) {
    Vec3 low = p[0], high = p[0];
    for (int i = 1; i < 4; ++i) {
      low = low.cwiseMin(p[i]);
      high = high.cwiseMax(p[i]);
    }
    int from[3], to[3];
    if (!samplesIn(low, high, from, to)) return;
    const Barycentric lambda(p);
    if (!lambda.finite()) return;
    Vec3 slope[Last - First];
    for (int c = First; c < Last; ++c) {
      slope[c - First].setZero();
      for (int i = 0; i < 4; ++i) slope[c - First] += values[i][c] * lambda.gradients[i];
    }
    double perZ[4];
    for (int i = 0; i < 4; ++i) perZ[i] = 1 / lambda.gradients[i][2];

    for (int x = from[0]; x <= to[0]; ++x) {
      for (int y = from[1]; y <= to[1]; ++y) {
        const double dx = x - p[0][0], dy = y - p[0][1], dz = -p[0][2];
        double zFrom = from[2], zTo = to[2];
        for (int i = 0; i < 4; ++i) {
          const Vec3& g = lambda.gradients[i];
          const double atZero = g[0] * dx + g[1] * dy + g[2] * dz + (i == 0 ? 1 : 0);
          const double crossing = -(atZero + kSharedFacetTolerance) * perZ[i];
          if (g[2] > 0) {
            zFrom = std::max(zFrom, crossing);
          } else if (g[2] < 0) {
            zTo = std::min(zTo, crossing);
          } else if (atZero < -kSharedFacetTolerance) {
            zTo = -1;
          }
        }
        if (!(zFrom <= zTo)) continue;
        const int z0 = static_cast<int>(std::ceil(zFrom)), z1 = static_cast<int>(std::floor(zTo));
        if (z0 > z1) continue;
        const int row = (x * kTile + y) * kTile;
        tile_.active[x] |= (std::uint64_t{0xff} >> (7 - (z1 - z0))) << (y * kTile + z0);
        for (int c = First; c < Last; ++c) {
          const Vec3& s = slope[c - First];
          const double base = values[0][c] + s[0] * dx + s[1] * dy + s[2] * dz;
          double* out = tile_.values[c].data() + row;
          for (int z = z0; z <= z1; ++z) out[z] = base + s[2] * z;
        }
      }
    }
  }

  const double perVoxel_;
  const Vec3 origin_;
  const Sampling sampling_;
  Tile<C> tile_;
};

/// Cells by the blocks of tiles that they meet, ascending in each.
class BlockBins {
 public:
  BlockBins(Index cellCount, const IndexBox& tiles,
            const std::function<IndexBox(Index)>& tilesOfCell)
      : tilesOfCell_(tilesOfCell), first_(tiles.min) {
    for (width_ = kBlockTiles; blockCount(tiles) > kMostBlocks; width_ *= 2) {
    }
    for (int k = 0; k < 3; ++k) counts_[k] = (tiles.max[k] - tiles.min[k]) / width_ + 1;
    // A fixed number of chunks counts and then fills in parallel; their order keeps cells sorted.
    const std::size_t blocks = static_cast<std::size_t>(blockCount(tiles));
    const int chunks = static_cast<int>(std::clamp<std::size_t>(
        (std::size_t{1} << 24) / blocks, 1, std::min<std::size_t>(64, cellCount / 4096 + 1)));
    Array<std::size_t> next(blocks * chunks + 1, 0);
    const auto chunkLoop = [&](const auto& body) {
      parallelFor<int>(
          chunks,
          [&](int chunk) {
            const auto bound = [&](int k) {
              return static_cast<Index>(std::int64_t{cellCount} * k / chunks);
            };
            for (Index cell = bound(chunk); cell < bound(chunk + 1); ++cell) {
              visitBlocks(cell, [&](std::size_t b) { body(b * chunks + chunk, cell); });
            }
          },
          1);
    };
    chunkLoop([&](std::size_t slot, Index) { ++next[slot + 1]; });
    for (std::size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
    begin_.resize(blocks + 1);
    for (std::size_t b = 0; b <= blocks; ++b) begin_[b] = next[b * chunks];
    items_.resize(next.back());
    chunkLoop([&](std::size_t slot, Index cell) { items_[next[slot]++] = cell; });
  }

  std::size_t blockCount() const { return begin_.size() - 1; }
  int width() const { return width_; }
  const Index* begin(std::size_t block) const { return items_.data() + begin_[block]; }
  const Index* end(std::size_t block) const { return items_.data() + begin_[block + 1]; }

  /// First and last tile of a block.
  IndexBox tiles(std::size_t block) const {
    const std::size_t perLayer = static_cast<std::size_t>(counts_[1]) * counts_[2];
    const Int at[3] = {static_cast<Int>(block / perLayer),
                       static_cast<Int>(block % perLayer / counts_[2]),
                       static_cast<Int>(block % counts_[2])};
    IndexBox box;
    for (int k = 0; k < 3; ++k) {
      box.min[k] = first_[k] + at[k] * width_;
      box.max[k] = box.min[k] + width_ - 1;
    }
    return box;
  }

 private:
  std::int64_t blockCount(const IndexBox& tiles) const {
    std::int64_t n = 1;
    for (int k = 0; k < 3; ++k) n *= (tiles.max[k] - tiles.min[k]) / width_ + 1;
    return n;
  }

  template <typename Visit>
  void visitBlocks(Index cell, const Visit& visit) const {
    const IndexBox box = tilesOfCell_(cell);
    if (box.empty()) return;
    const auto block = [&](Int tile, int k) { return (tile - first_[k]) / width_; };
    for (Int i = block(box.min[0], 0); i <= block(box.max[0], 0); ++i) {
      for (Int j = block(box.min[1], 1); j <= block(box.max[1], 1); ++j) {
        for (Int k = block(box.min[2], 2); k <= block(box.max[2], 2); ++k) {
          visit((static_cast<std::size_t>(i) * counts_[1] + j) * counts_[2] + k);
        }
      }
    }
  }

  std::function<IndexBox(Index)> tilesOfCell_;
  std::array<Int, 3> first_;
  std::array<Int, 3> counts_{};
  Int width_ = kBlockTiles;
  Array<std::size_t> begin_;
  Array<Index> items_;
};

}  // namespace

template <int C>
void rasterize(const PieceSource<C>& source, const GridFrame& frame, Sampling sampling,
               const std::function<void(const Tile<C>&)>& sink, const std::string& stage,
               const ProgressCallback& progress) {
  if (!(frame.voxelSize > 0) || !std::isfinite(frame.voxelSize)) {
    throw InputError("voxel size", "is not a positive number");
  }
  const double after = sampling == Sampling::Staggered ? 0.5 : 0.0;
  const auto tilesOfBox = [&](const Box& box) {
    IndexBox tiles;
    for (int k = 0; k < 3; ++k) {
      const double low = (box.min[k] - frame.origin[k]) / frame.voxelSize - kMargin;
      const double high = (box.max[k] - frame.origin[k]) / frame.voxelSize + after + kMargin;
      if (!(std::abs(low) < kLargestIndex && std::abs(high) < kLargestIndex)) {
        throw InputError("voxel size", "is so small that the grid needs more than 2^30 voxels");
      }
      const Int from = static_cast<Int>(std::ceil(low)), to = static_cast<Int>(std::floor(high));
      tiles.min[k] = floorDivide(from, kTile);
      tiles.max[k] = from > to ? tiles.min[k] - 1 : floorDivide(to, kTile);
    }
    return tiles;
  };
  Box bounds;
  for (const Vec3& p : source.positions()) bounds.extend(p);
  if (bounds.empty()) return;
  const IndexBox all = tilesOfBox(bounds);
  if (all.empty()) return;
  const BlockBins blocks(source.complex().cellCount(), all,
                         [&](Index cell) { return tilesOfBox(source.cellBox(cell)); });

  tbb::enumerable_thread_specific<TilePainter<C>> painters(
      [&] { return TilePainter<C>(frame, sampling); });
  std::vector<std::uint32_t> begin;
  std::vector<Index> items;
  for (std::size_t block = 0; block < blocks.blockCount(); ++block) {
    reportProgress(progress, {stage, block, blocks.blockCount(), "blocks"});
    const Index *first = blocks.begin(block), *last = blocks.end(block);
    if (first == last) continue;
    // Bin the block's cells to its tiles.
    const IndexBox span = blocks.tiles(block);
    const Int width = blocks.width();
    const std::size_t tileCount = static_cast<std::size_t>(width) * width * width;
    const auto visitTiles = [&](Index cell, const auto& visit) {
      const IndexBox box = tilesOfBox(source.cellBox(cell));
      Int from[3], to[3];
      for (int k = 0; k < 3; ++k) {
        from[k] = std::max(box.min[k], span.min[k]) - span.min[k];
        to[k] = std::min(box.max[k], span.max[k]) - span.min[k];
      }
      for (Int i = from[0]; i <= to[0]; ++i) {
        for (Int j = from[1]; j <= to[1]; ++j) {
          for (Int k = from[2]; k <= to[2]; ++k) {
            visit((static_cast<std::size_t>(i) * width + j) * width + k);
          }
        }
      }
    };
    begin.assign(tileCount + 1, 0);
    for (const Index* cell = first; cell != last; ++cell) {
      visitTiles(*cell, [&](std::size_t t) { ++begin[t + 1]; });
    }
    for (std::size_t t = 1; t <= tileCount; ++t) begin[t] += begin[t - 1];
    items.resize(begin.back());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (const Index* cell = first; cell != last; ++cell) {
      visitTiles(*cell, [&](std::size_t t) { items[next[t]++] = *cell; });
    }
    parallelFor<std::size_t>(
        tileCount,
        [&](std::size_t t) {
          if (begin[t] == begin[t + 1]) return;
          const Int i = static_cast<Int>(t / (static_cast<std::size_t>(width) * width)),
                    j = static_cast<Int>(t / width % width), k = static_cast<Int>(t % width);
          TilePainter<C>& painter = painters.local();
          painter.begin(
              {(span.min[0] + i) * kTile, (span.min[1] + j) * kTile, (span.min[2] + k) * kTile});
          const typename PieceSource<C>::Filter wanted = [&](const Box& box) {
            return painter.wants(box);
          };
          const typename PieceSource<C>::Sink paint = [&](const Piece<C>& piece) {
            painter.paint(piece);
          };
          for (std::uint32_t n = begin[t]; n < begin[t + 1]; ++n) {
            source.visitPieces(items[n], wanted, paint);
          }
          if (!painter.empty()) sink(painter.tile());
        },
        1);
  }
  reportProgress(progress, {stage, blocks.blockCount(), blocks.blockCount(), "blocks"});
}

template void rasterize<1>(const PieceSource<1>&, const GridFrame&, Sampling,
                           const std::function<void(const Tile<1>&)>&, const std::string&,
                           const ProgressCallback&);
template void rasterize<3>(const PieceSource<3>&, const GridFrame&, Sampling,
                           const std::function<void(const Tile<3>&)>&, const std::string&,
                           const ProgressCallback&);

}  // namespace octet
