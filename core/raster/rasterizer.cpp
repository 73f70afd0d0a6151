// SPDX-License-Identifier: Apache-2.0
#include "rasterizer.h"

#include <algorithm>
#include <cmath>

#include "../topology/domain_box.h"
#include "patch_loop.h"

namespace octet {
namespace {

constexpr int kTile = Tile<1>::kWidth, kInTile = kTile - 1;
constexpr int kPatch = kPatchSamples;
/// Boxes are widened by this many voxels, so that samples on facets are found from both sides.
constexpr double kMargin = 1e-7;
/// A barycentric coordinate that grows less than this per voxel along z is taken as growing this
/// much; along a patch that is much less than kSharedFacetTolerance.
constexpr double kSteepest = 1e-12;

using Int = GridIndex;

/// Rounds a small number up that is not negative.
int ceilPositive(double x) {
  const int n = static_cast<int>(x);
  return n + (n < x ? 1 : 0);
}

/// What vertical lines have in common with a tetrahedron: a range of integers z.
class Columns {
 public:
  /// @param origin  where lambda's origin lies
  /// @param from, to  the range to narrow, not negative
  Columns(const Barycentric& lambda, const Vec3& origin, int from, int to)
      : origin_(origin), all_(from, -(to + 1)) {
    int count[2] = {0, 0};
    for (int i = 0; i < 4; ++i) {
      // lambda_i >= -tolerance bounds z from below when lambda_i grows with z, else -z.
      const Vec3& g = lambda.gradients[i];
      const int side = g[2] >= 0 ? 0 : 1;
      const double perLambda = 1 / std::max(std::abs(g[2]), kSteepest);
      Ends& ends = ends_[count[side]++];
      ends.start[side] = (side == 0 ? origin[2] + kRoundUp : -origin[2] - 1) -
                         ((i == 0 ? 1 : 0) + kSharedFacetTolerance) * perLambda;
      ends.perX[side] = -g[0] * perLambda;
      ends.perY[side] = -g[1] * perLambda;
    }
  }

  /// Moves to a line's place.
  void moveTo(double x, double y) {
    for (int k = 0; k < kMost; ++k) {
      const Ends& e = ends_[k];
      here_[k] = e.start + (x - origin_[0]) * e.perX + (y - origin_[1]) * e.perY;
    }
  }
  void stepAlongY() {
    for (int k = 0; k < kMost; ++k) here_[k] += ends_[k].perY;
  }

  /// The range, its end not included; nothing when it ends before it begins.
  void range(int* begin, int* end) const {
    const Eigen::Array2d ends = all_.max(here_[0]).max(here_[1].max(here_[2])).min(last);
    *begin = static_cast<int>(ends[0]);
    *end = static_cast<int>(-ends[1]);
  }

 private:
  /// A tetrahedron has at most as many facets on one side.
  static constexpr int kMost = 3;
  /// Rounds a positive number up when rounding down follows.
  static constexpr double kRoundUp = 1 - 1e-12;
  /// Lower end of z, and minus its upper end, as linear functions of x and y.
  struct Ends {
    Eigen::Array2d start = Eigen::Array2d::Constant(-HUGE_VAL);
    Eigen::Array2d perX = Eigen::Array2d::Zero(), perY = Eigen::Array2d::Zero();
  };
  const Eigen::Array2d last{kPatch, 0};
  Vec3 origin_;
  Eigen::Array2d all_;
  std::array<Ends, kMost + 1> ends_;
  std::array<Eigen::Array2d, kMost> here_;
};

/// Draws linear pieces into a patch of tiles.
template <int C>
class PatchPainter {
 public:
  PatchPainter(const PieceSource<C>& source, const GridFrame& frame, Sampling sampling)
      : source_(source),
        perVoxel_(1 / frame.voxelSize),
        origin_(frame.origin),
        sampling_(sampling),
        tiles_(kPatchTiles * kPatchTiles * kPatchTiles) {}

  /// @param tile  first tile of the patch, in tiles
  void begin(const std::array<Int, 3>& tile) {
    for (int k = 0; k < 3; ++k) first_[k] = tile[k] * kTile;
    used_.fill(false);
  }

  void paint(Index cell) {
    const typename PieceSource<C>::Filter wanted = [this](const Box& box) { return wants(box); };
    const typename PieceSource<C>::Sink paint = [this](const Piece<C>& piece) {
      paintPiece(piece);
    };
    source_.visitPieces(cell, wanted, paint);
  }

  /// Hands out the tiles that hold something.
  void finish(const TileSink<C>& sink) const {
    for (std::size_t k = 0; k < tiles_.size(); ++k) {
      if (used_[k]) sink(tiles_[k]);
    }
  }

 private:
  /// Does a box hold any of the patch' samples?
  bool wants(const Box& box) const {
    const Vec3 low = inPatch(box.min), high = inPatch(box.max);
    int from[3], to[3];
    if (sampling_ == Sampling::Collocated) return samplesIn(low, high, from, to);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 shift = 0.5 * Vec3::Unit(axis);
      if (samplesIn(low + shift, high + shift, from, to)) return true;
    }
    return false;
  }

  void paintPiece(const Piece<C>& piece) {
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = inPatch(piece.points[i]);
    const Barycentric lambda(p);
    if (!lambda.finite()) return;
    Linear field;
    field.value = piece.values[0];
    const auto& v = piece.values;
    for (int axis = 0; axis < 3; ++axis) {
      field.slope.col(axis) = (v[1] - v[0]) * lambda.gradients[1][axis] +
                              (v[2] - v[0]) * lambda.gradients[2][axis] +
                              (v[3] - v[0]) * lambda.gradients[3][axis];
    }
    if (sampling_ == Sampling::Collocated) {
      paintComponents<0, C>(p, lambda, field, Vec3::Zero());
    } else if constexpr (C == 3) {
      // The sample of component c at index i lies at i - 1/2 along c.
      paintComponents<0, 1>(p, lambda, field, 0.5 * Vec3::UnitX());
      paintComponents<1, 2>(p, lambda, field, 0.5 * Vec3::UnitY());
      paintComponents<2, 3>(p, lambda, field, 0.5 * Vec3::UnitZ());
    }
  }

  /// value + slope (x - origin of the barycentric coordinates)
  struct Linear {
    typename Piece<C>::Value value;
    Eigen::Matrix<double, C, 3> slope;
  };

  /// In voxels from the patch' first sample.
  Vec3 inPatch(const Vec3& x) const { return (x - origin_) * perVoxel_ - first_; }

  /// The patch' integer points in a box.
  static bool samplesIn(const Vec3& low, const Vec3& high, int* from, int* to) {
    for (int k = 0; k < 3; ++k) {
      if (!(high[k] >= -kMargin && low[k] <= kPatch - 1 + kMargin)) return false;
      from[k] = ceilPositive(std::max(low[k] - kMargin, 0.0));
      to[k] = static_cast<int>(std::min(high[k] + kMargin, kPatch - 1.0));
      if (from[k] > to[k]) return false;
    }
    return true;
  }

  /// Components First..Last-1 at the integer points inside the tetrahedron `p`, shifted.
  template <int First, int Last>
  void paintComponents(const std::array<Vec3, 4>& p, const Barycentric& lambda, const Linear& field,
                       const Vec3& shift) {
    const Vec3 low = p[0].cwiseMin(p[1]).cwiseMin(p[2].cwiseMin(p[3])) + shift;
    const Vec3 high = p[0].cwiseMax(p[1]).cwiseMax(p[2].cwiseMax(p[3])) + shift;
    int from[3], to[3];
    if (!samplesIn(low, high, from, to)) return;
    const Vec3 origin = lambda.origin + shift;
    // Whether a row meets the tetrahedron is hard to foresee for a processor: list those that do
    // first, without a branch.
    std::array<Row, kPatch * kPatch + 1> rows;
    int count = 0;
    Columns columns(lambda, origin, from[2], to[2]);
    for (int x = from[0]; x <= to[0]; ++x) {
      columns.moveTo(x, from[1]);
      for (int y = from[1]; y <= to[1]; ++y, columns.stepAlongY()) {
        Row& row = rows[count];
        row.x = x;
        row.y = y;
        columns.range(&row.begin, &row.end);
        count += row.begin < row.end ? 1 : 0;
      }
    }
    for (int k = 0; k < count; ++k) paintRow<First, Last>(rows[k], field, origin);
  }

  struct Row {
    int x, y, begin, end;
  };
  template <int First, int Last>
  void paintRow(const Row& r, const Linear& field, const Vec3& origin) {
    const auto& [x, y, begin, end] = r;
    const Vec3 offset(x - origin[0], y - origin[1], -origin[2]);
    const typename Piece<C>::Value base = field.value + field.slope * offset;
    for (int z = begin; z < end; z = (z | kInTile) + 1) {
      const int last = std::min(end - 1, z | kInTile);
      Tile<C>& tile = tileAt(x / kTile, y / kTile, z / kTile);
      const int line = (y & kInTile) * kTile, row = (x & kInTile) * kTile * kTile + line;
      tile.active[x & kInTile] |= (std::uint64_t{0xff} >> (kInTile - (last - z)))
                                  << (line + (z & kInTile));
      for (int k = z; k <= last; ++k) {
        for (int c = First; c < Last; ++c) {
          tile.values[c][row + (k & kInTile)] = base[c] + field.slope(c, 2) * k;
        }
      }
    }
  }

  Tile<C>& tileAt(int i, int j, int k) {
    const int n = (i * kPatchTiles + j) * kPatchTiles + k;
    Tile<C>& tile = tiles_[n];
    if (!used_[n]) {
      used_[n] = true;
      const int at[3] = {i, j, k};
      for (int axis = 0; axis < 3; ++axis) {
        tile.origin[axis] = static_cast<Int>(first_[axis]) + at[axis] * kTile;
      }
      for (auto& component : tile.values) component.fill(0);
      tile.active.fill(0);
    }
    return tile;
  }

  const PieceSource<C>& source_;
  const double perVoxel_;
  const Vec3 origin_;
  const Sampling sampling_;
  Vec3 first_ = Vec3::Zero();  // the patch' first sample
  std::vector<Tile<C>> tiles_;
  std::array<bool, kPatchTiles * kPatchTiles * kPatchTiles> used_{};
};

}  // namespace

template <int C>
void rasterize(const PieceSource<C>& source, const GridFrame& frame, Sampling sampling,
               const TileSink<C>& sink, const std::string& stage, const Context& context) {
  checkVoxelSize(frame);
  const double after = sampling == Sampling::Staggered ? 0.5 : 0.0;
  const auto tilesOfBox = [&](const Box& box) {
    const Vec3 low = inVoxels(box.min, frame).array() - kMargin;
    const Vec3 high = inVoxels(box.max, frame).array() + after + kMargin;
    return tilesOfSamples(low.array().ceil(), high.array().floor());
  };
  const Box bounds = domainBox(source.complex(), source.positions());
  if (bounds.empty()) return;
  const CellTiles cells{source.complex().cellCount(), tilesOfBox(bounds),
                        [&](Index cell) { return tilesOfBox(source.cellBox(cell)); }, frame.window};
  const auto makePatch = [&] { return PatchPainter<C>(source, frame, sampling); };
  fillPatches<C>(cells, makePatch, sink, stage, context);
}

template void rasterize<1>(const PieceSource<1>&, const GridFrame&, Sampling, const TileSink<1>&,
                           const std::string&, const Context&);
template void rasterize<3>(const PieceSource<3>&, const GridFrame&, Sampling, const TileSink<3>&,
                           const std::string&, const Context&);

}  // namespace octet
