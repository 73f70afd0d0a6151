// SPDX-License-Identifier: Apache-2.0
#include "flux_rasterizer.h"

#include <cmath>

#include <tbb/enumerable_thread_specific.h>

#include "../field/block_bins.h"
#include "../field/piece.h"
#include "edge_circulations.h"

namespace octet {
namespace {

using Int = GridIndex;
constexpr int kTile = Tile<3>::kWidth, kPatch = kPatchTiles * kTile;
/// Corners of the lattice of edges that a patch of voxels needs: one more on either side.
constexpr int kCorners = kPatch + 2;
/// An edge this nearly covered by cells, per length, lies wholly inside the domain.
constexpr double kCovered = 1 - 1e-6;
/// Less than this is none.
constexpr double kUncovered = 1e-6;
constexpr double kLargestIndex = 1 << 30;
constexpr std::size_t kReports = 100, kFewestBlocks = 256;
/// Voxels by which an edge reaches beyond the samples that need it.
constexpr double kReach = 2;
/// The lattice is moved by this many voxels against the mesh, so that no edge lies in a facet
/// between two cells, which would both count it. Less than what floats can tell.
const Vec3 kOffFacets = 1e-7 * Vec3(0.29, 0.53, 0.83);

/// Fluxes through the squares of one patch of voxels.
class FluxPatch {
 public:
  FluxPatch(const PotentialField& field, const GridFrame& frame, Sampling sampling)
      : field_(field),
        perVoxel_(1 / frame.voxelSize),
        origin_(frame.origin),
        staggered_(sampling == Sampling::Staggered),
        perArea_(perVoxel_ * perVoxel_ / (staggered_ ? 1 : 4)),
        edges_(kCorners) {}

  void begin(const std::array<Int, 3>& tile) {
    for (int k = 0; k < 3; ++k) first_[k] = tile[k] * kTile;
    // Corner 0 of the lattice lies one before the patch: of the faces, or of the samples.
    const double corner = staggered_ ? -1.5 : -1.0;
    shift_ = -origin_ * perVoxel_ -
             Vec3(static_cast<double>(first_[0]), static_cast<double>(first_[1]),
                  static_cast<double>(first_[2])) -
             Vec3::Constant(corner) + kOffFacets;
    edges_.clear();
  }

  void paint(Index cell) {
    Box box;
    const Complex& c = field_.complex();
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      box.extend(inLattice(field_.positions()[c.cellVertex(cell, i)]));
    }
    if (!edges_.meets(box)) return;
    field_.visitPieces(cell, [&](PotentialPiece piece) {
      for (Vec3& p : piece.points) p = inLattice(p);
      edges_.add(piece);
    });
  }

  void finish(const std::function<void(const Tile<3>&)>& sink) {
    if (!edges_.used()) return;
    for (int i = 0; i < kPatchTiles; ++i) {
      for (int j = 0; j < kPatchTiles; ++j) {
        for (int k = 0; k < kPatchTiles; ++k) finishTile({i, j, k}, sink);
      }
    }
  }

 private:
  using Corner = std::array<int, 3>;

  Vec3 inLattice(const Vec3& x) const { return x * perVoxel_ + shift_; }

  static Corner moved(Corner c, int axis, int by) {
    c[axis] += by;
    return c;
  }

  /// Circulation around a square across `axis`, with corner `c` and sides of `n` edges; and how
  /// much of its sides lies inside: none, some, all.
  double around(const Corner& c, int axis, int n, double* least, double* most) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      const Corner sides[4] = {moved(c, u, k), moved(moved(c, u, n), v, k),
                               moved(moved(c, v, n), u, k), moved(c, v, k)};
      for (int s = 0; s < 4; ++s) {
        const int along = s % 2 == 0 ? u : v;
        sum += (s == 0 || s == 1 ? 1 : -1) * edges_.circulation(along, sides[s]);
        const double covered = edges_.coverage(along, sides[s]);
        *least = std::min(*least, covered);
        *most = std::max(*most, covered);
      }
    }
    return sum;
  }

  /// Does any, or do all, of a voxel's twelve edges lie inside? `c` is its first corner.
  bool touched(const Corner& c) const { return edgesOfVoxel(c)[1] > kUncovered; }
  bool inside(const Corner& c) const { return edgesOfVoxel(c)[0] > kCovered; }
  std::array<double, 2> edgesOfVoxel(const Corner& c) const {
    double least = 1, most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int k = 0; k < 4; ++k) {
        const double covered = edges_.coverage(axis, moved(moved(c, u, k & 1), v, k >> 1));
        least = std::min(least, covered);
        most = std::max(most, covered);
      }
    }
    return {least, most};
  }

  void finishTile(const Corner& at, const std::function<void(const Tile<3>&)>& sink) {
    for (int k = 0; k < 3; ++k) tile_.origin[k] = first_[k] + at[k] * kTile;
    tile_.active.fill(0);
    bool used = false;
    for (int n = 0; n < Tile<3>::kSize; ++n) {
      // Corner 1 is the first voxel's own.
      const Corner c = {at[0] * kTile + n / 64 + 1, at[1] * kTile + n / 8 % 8 + 1,
                        at[2] * kTile + n % 8 + 1};
      const bool active = staggered_ ? fillFaces(c, n) : fillSquares(c, n);
      if (active) tile_.active[n >> 6] |= std::uint64_t{1} << (n & 63);
      used = used || active;
      for (const auto& component : tile_.values) used = used || component[n] != 0;
    }
    if (used) sink(tile_);
  }

  bool fillFaces(const Corner& c, int n) {
    for (int axis = 0; axis < 3; ++axis) {
      double least = 1, most = 0;
      const double flux = around(c, axis, 1, &least, &most);
      const bool known = field_.zeroOnBoundary() || least > kCovered;
      tile_.values[axis][n] = known ? flux * perArea_ : 0;
    }
    if (!field_.zeroOnBoundary()) return inside(c);
    return touched(c) || touched(moved(c, 0, -1)) || touched(moved(c, 1, -1)) ||
           touched(moved(c, 2, -1));
  }

  bool fillSquares(const Corner& c, int n) {
    double least = 1, most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Corner first = moved(moved(c, (axis + 1) % 3, -1), (axis + 2) % 3, -1);
      tile_.values[axis][n] = perArea_ * around(first, axis, 2, &least, &most);
    }
    if (least > kCovered) return true;
    for (auto& component : tile_.values) component[n] = 0;
    return false;
  }

  const PotentialField& field_;
  const double perVoxel_;
  const Vec3 origin_;
  const bool staggered_;
  const double perArea_;
  std::array<Int, 3> first_{};
  Vec3 shift_ = Vec3::Zero();
  EdgeCirculations edges_;
  Tile<3> tile_;
};

/// Tiles with a sample that edges through a box could belong to.
IndexBox tilesOfBox(const Box& box, const GridFrame& frame) {
  IndexBox tiles;
  for (int k = 0; k < 3; ++k) {
    const double low = (box.min[k] - frame.origin[k]) / frame.voxelSize - kReach;
    const double high = (box.max[k] - frame.origin[k]) / frame.voxelSize + kReach;
    if (!(std::abs(low) < kLargestIndex && std::abs(high) < kLargestIndex)) {
      throw InputError("voxel size", "is so small that the grid needs more than 2^30 voxels");
    }
    tiles.min[k] = floorDivide(static_cast<Int>(std::floor(low)), kTile);
    tiles.max[k] = floorDivide(static_cast<Int>(std::ceil(high)), kTile);
  }
  return tiles;
}

}  // namespace

void rasterizeFluxes(const PotentialField& field, const GridFrame& frame, Sampling sampling,
                     const std::function<void(const Tile<3>&)>& sink, const std::string& stage,
                     const ProgressCallback& progress) {
  if (!(frame.voxelSize > 0) || !std::isfinite(frame.voxelSize)) {
    throw InputError("voxel size", "is not a positive number");
  }
  Box bounds;
  for (const Vec3& p : field.positions()) bounds.extend(p);
  if (bounds.empty()) return;
  const Complex& c = field.complex();
  const BlockBins blocks(c.cellCount(), tilesOfBox(bounds, frame), [&](Index cell) {
    Box box;
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      box.extend(field.positions()[c.cellVertex(cell, i)]);
    }
    return tilesOfBox(box, frame);
  });
  tbb::enumerable_thread_specific<FluxPatch> patches(
      [&] { return FluxPatch(field, frame, sampling); });
  const auto fillBlock = [&](std::size_t block) {
    if (blocks.begin(block) == blocks.end(block)) return;
    FluxPatch& patch = patches.local();
    blocks.visitPatches(block, [&](const std::array<Int, 3>& tile) {
      patch.begin(tile);
      for (const Index* cell = blocks.begin(block); cell != blocks.end(block); ++cell) {
        patch.paint(*cell);
      }
      patch.finish(sink);
    });
  };
  const std::size_t atOnce = std::max(kFewestBlocks, blocks.blockCount() / kReports);
  for (std::size_t block = 0; block < blocks.blockCount(); block += atOnce) {
    reportProgress(progress, {stage, block, blocks.blockCount(), "blocks"});
    parallelFor<std::size_t>(
        std::min(atOnce, blocks.blockCount() - block), [&](std::size_t k) { fillBlock(block + k); },
        1);
  }
  reportProgress(progress, {stage, blocks.blockCount(), blocks.blockCount(), "blocks"});
}

}  // namespace octet
