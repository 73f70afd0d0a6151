// SPDX-License-Identifier: Apache-2.0
#include "flux_rasterizer.h"

#include <algorithm>
#include <cmath>

#include "../hodge/edge_circulations.h"
#include "patch_loop.h"

namespace octet {
namespace {

using Int = GridIndex;
constexpr int kTile = Tile<3>::kWidth, kPatch = kPatchSamples;
/// An edge this nearly covered by cells, per length, lies wholly inside the domain.
constexpr double kCovered = 1 - 1e-6;
/// Less than this is none.
constexpr double kUncovered = 1e-6;
/// Voxels by which an edge reaches beyond the samples that need it.
constexpr double kReach = 2;
/// The lattice is moved by this many voxels against the mesh, so that no edge lies in a facet
/// between two cells, which would both count it. Less than what floats can tell.
const Vec3 kOffFacets = 1e-7 * Vec3(0.29, 0.53, 0.83);

/// Lattice of edges around one patch of voxels, and circulations around its squares.
class EdgePatch {
 public:
  void begin(const std::array<Int, 3>& tile) {
    for (int k = 0; k < 3; ++k) first_[k] = tile[k] * kTile;
    shift_ = toCorner_ + kOffFacets -
             Vec3(static_cast<double>(first_[0]), static_cast<double>(first_[1]),
                  static_cast<double>(first_[2]));
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

 protected:
  using Corner = std::array<int, 3>;

  /// @param margin  edges on either side of the patch
  /// @param before  voxels from the lattice's corner at a voxel's index to the voxel's sample
  EdgePatch(const PotentialField& field, const GridFrame& frame, int margin, double before)
      : field_(field),
        perVoxel_(1 / frame.voxelSize),
        margin_(margin),
        edges_(kPatch + 2 * margin),
        toCorner_(Vec3::Constant(margin + before) - frame.origin * perVoxel_) {}

  static Corner moved(Corner c, int axis, int by) {
    c[axis] += by;
    return c;
  }

  /// Of the edges of something, how much lies inside the domain.
  struct Coverage {
    double least = 1, most = 0;

    void add(double covered) {
      least = std::min(least, covered);
      most = std::max(most, covered);
    }
    bool all() const { return least > kCovered; }
    bool any() const { return most > kUncovered; }
  };

  /// Circulation around a square across `axis`, with corner `c` and sides of `n` edges.
  double around(const Corner& c, int axis, int n, Coverage* covered) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      const Corner sides[4] = {moved(c, u, k), moved(moved(c, u, n), v, k),
                               moved(moved(c, v, n), u, k), moved(c, v, k)};
      for (int s = 0; s < 4; ++s) {
        const int along = s % 2 == 0 ? u : v;
        sum += (s == 0 || s == 1 ? 1 : -1) * edges_.circulation(along, sides[s]);
        covered->add(edges_.coverage(along, sides[s]));
      }
    }
    return sum;
  }

  /// Calls fill(corner of a voxel, its number in the tile) for the voxels of every tile of the
  /// patch, which puts values into tile_ and tells whether the voxel is active.
  template <typename Fill>
  void visitTiles(const Fill& fill, const TileSink<3>& sink) {
    for (int t = 0; t < kPatchTiles * kPatchTiles * kPatchTiles; ++t) {
      const Corner at = {t / (kPatchTiles * kPatchTiles), t / kPatchTiles % kPatchTiles,
                         t % kPatchTiles};
      for (int k = 0; k < 3; ++k) tile_.origin[k] = first_[k] + at[k] * kTile;
      tile_.active.fill(0);
      bool used = false;
      for (int n = 0; n < Tile<3>::kSize; ++n) {
        const Corner c = {at[0] * kTile + n / 64 + margin_, at[1] * kTile + n / 8 % 8 + margin_,
                          at[2] * kTile + n % 8 + margin_};
        const bool active = fill(c, n);
        if (active) tile_.active[n >> 6] |= std::uint64_t{1} << (n & 63);
        used = used || active;
        for (const auto& component : tile_.values) used = used || component[n] != 0;
      }
      if (used) sink(tile_);
    }
  }

  const PotentialField& field_;
  const double perVoxel_;
  const int margin_;
  EdgeCirculations edges_;
  Tile<3> tile_;

 private:
  Vec3 inLattice(const Vec3& x) const { return x * perVoxel_ + shift_; }

  const Vec3 toCorner_;
  std::array<Int, 3> first_{};
  Vec3 shift_ = Vec3::Zero();
};

/// Fluxes through the faces of voxels: for a staggered grid.
class FacePatch : public EdgePatch {
 public:
  FacePatch(const PotentialField& field, const GridFrame& frame)
      : EdgePatch(field, frame, /*margin=*/1, /*before=*/0.5) {}

  void finish(const TileSink<3>& sink) {
    if (!edges_.used()) return;
    visitTiles([&](const Corner& c, int n) { return fill(c, n); }, sink);
  }

 private:
  bool fill(const Corner& c, int n) {
    for (int axis = 0; axis < 3; ++axis) {
      Coverage covered;
      const double flux = around(c, axis, 1, &covered);
      const bool known = field_.zeroOnBoundary() || covered.all();
      tile_.values[axis][n] = known ? flux * perVoxel_ * perVoxel_ : 0;
    }
    if (!field_.zeroOnBoundary()) return edgesOfVoxel(c).all();
    return touched(c) || touched(moved(c, 0, -1)) || touched(moved(c, 1, -1)) ||
           touched(moved(c, 2, -1));
  }

  bool touched(const Corner& c) const { return edgesOfVoxel(c).any(); }
  /// Of a voxel's twelve edges; `c` is its first corner.
  Coverage edgesOfVoxel(const Corner& c) const {
    Coverage covered;
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int k = 0; k < 4; ++k) {
        covered.add(edges_.coverage(axis, moved(moved(c, u, k & 1), v, k >> 1)));
      }
    }
    return covered;
  }
};

/// Mean fluxes around the samples of a collocated grid.
class MeanPatch : public EdgePatch {
 public:
  MeanPatch(const PotentialField& field, const GridFrame& frame, double neighbours)
      : EdgePatch(field, frame, /*margin=*/2, /*before=*/0),
        neighbours_(neighbours),
        squares_(static_cast<std::size_t>(kSquares) * kSquares * kSquares) {}

  void finish(const TileSink<3>& sink) {
    if (!edges_.used()) return;
    measureSquares();
    visitTiles([&](const Corner& c, int n) { return fill(c, n); }, sink);
  }

 private:
  /// Squares around the patch' samples and one more on either side.
  static constexpr int kSquares = kPatch + 2;
  /// Mean velocity through the squares of 2 x 2 voxels around a sample, one across each axis.
  struct Squares {
    Vec3 mean;
    bool inside;
  };

  /// @param c  the sample's corner of the lattice
  Squares& squaresAt(const Corner& c) {
    const std::size_t row = static_cast<std::size_t>(c[0] - 1) * kSquares + (c[1] - 1);
    return squares_[row * kSquares + (c[2] - 1)];
  }

  void measureSquares() {
    for (int x = 1; x <= kSquares; ++x) {
      for (int y = 1; y <= kSquares; ++y) {
        for (int z = 1; z <= kSquares; ++z) {
          const Corner c = {x, y, z};
          Coverage covered;
          Squares& squares = squaresAt(c);
          for (int axis = 0; axis < 3; ++axis) {
            const Corner first = moved(moved(c, (axis + 1) % 3, -1), (axis + 2) % 3, -1);
            squares.mean[axis] = around(first, axis, 2, &covered) * perVoxel_ * perVoxel_ / 4;
          }
          squares.inside = covered.all();
        }
      }
    }
  }

  bool fill(const Corner& c, int n) {
    const Squares& own = squaresAt(c);
    bool inside = own.inside;
    Vec3 sum = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        const Squares& other = squaresAt(moved(c, axis, side));
        inside = inside && other.inside;
        sum += other.mean;
      }
    }
    const Vec3 value = (1 - 6 * neighbours_) * own.mean + neighbours_ * sum;
    for (int axis = 0; axis < 3; ++axis) tile_.values[axis][n] = inside ? value[axis] : 0;
    return inside;
  }

  const double neighbours_;
  std::vector<Squares> squares_;
};

/// Fills patch after patch. @param makePatch  for each thread that needs one
template <typename MakePatch>
void rasterizePatches(const PotentialField& field, const GridFrame& frame,
                      const MakePatch& makePatch, const TileSink<3>& sink, const std::string& stage,
                      const Context& context) {
  checkVoxelSize(frame);
  Box bounds;
  for (const Vec3& p : field.positions()) bounds.extend(p);
  if (bounds.empty()) return;
  // Tiles with a sample that edges through a box could belong to.
  const auto tilesOfBox = [&](const Box& box) {
    const Vec3 low = inVoxels(box.min, frame).array() - kReach;
    const Vec3 high = inVoxels(box.max, frame).array() + kReach;
    return tilesOfSamples(low.array().floor(), high.array().ceil());
  };
  const Complex& c = field.complex();
  const auto tilesOfCell = [&](Index cell) {
    Box box;
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      box.extend(field.positions()[c.cellVertex(cell, i)]);
    }
    return tilesOfBox(box);
  };
  const CellTiles cells{c.cellCount(), tilesOfBox(bounds), tilesOfCell, frame.window};
  fillPatches<3>(cells, makePatch, sink, stage, context);
}

/// How much of its Laplacian is added to a velocity. By the limit on the lattice, times the edge
/// squared: a sixth of its mask's second moment (SCHEME.md section 5: 12 neighbours of weight
/// 19/387 at distance 1, 6 of 5/774 at sqrt 2). By the mean over a square of 2 x 2 voxels, times
/// the voxel squared: v_x gains (v_x,yy + v_x,zz) / 6 and so on, which is nearest to 2/15 of the
/// Laplacian in the mean over plane waves of all directions without divergence.
constexpr double kLimitSpread = (12 * 19.0 / 387 + 6 * 2 * 5.0 / 774) / 6;
constexpr double kSquareSpread = 2.0 / 15;
/// Of the difference this part is made up for, which was measured to be best.
constexpr double kPart = 0.5;
/// With more, a voxel's own value would count less than nothing.
constexpr double kMostNeighbours = 1.0 / 6;

}  // namespace

void rasterizeFluxes(const PotentialField& field, const GridFrame& frame, const TileSink<3>& sink,
                     const std::string& stage, const Context& context) {
  rasterizePatches(
      field, frame, [&] { return FacePatch(field, frame); }, sink, stage, context);
}

void rasterizeMeanFluxes(const PotentialField& field, const GridFrame& frame, double neighbours,
                         const TileSink<3>& sink, const std::string& stage,
                         const Context& context) {
  rasterizePatches(
      field, frame, [&] { return MeanPatch(field, frame, neighbours); }, sink, stage, context);
}

double neighbourWeight(double voxelsPerEdge) {
  const double missing = kLimitSpread / (voxelsPerEdge * voxelsPerEdge) - kSquareSpread;
  return std::clamp(kPart * missing, 0.0, kMostNeighbours);
}

}  // namespace octet
