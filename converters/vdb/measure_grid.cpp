// SPDX-License-Identifier: Apache-2.0
#include "measure_grid.h"

#include <cmath>

#include <openvdb/math/Operators.h>

#include <octet/core/base/reported_loop.h>

#include "block_walk.h"
#include "grid_stencils.h"

namespace octet {
namespace {

using openvdb::Coord;

/// Sums and maxima over a lot of voxels.
struct Sums {
  std::uint64_t active = 0, inside = 0, free = 0, curlInside = 0;
  double maxDivergence = 0, squaredDivergence = 0, maxSquaredCurl = 0, squaredCurl = 0;
  double minSquaredSpeed = HUGE_VAL, maxSquaredSpeed = 0, squaredSpeed = 0;
  double outflow = 0, throughflow = 0;
  Coord at;

  void addSpeeds(double squared, std::uint64_t count) {
    active += count;
    minSquaredSpeed = std::min(minSquaredSpeed, squared);
    maxSquaredSpeed = std::max(maxSquaredSpeed, squared);
    squaredSpeed += static_cast<double>(count) * squared;
  }
  void addFlux(double through, int side, double count) {
    outflow += (side ? count : -count) * through;
    throughflow += count * std::abs(through);
  }
  /// @param rounding  divergences up to this are none
  void addDivergence(double div, double rounding, std::uint64_t count, const Coord& ijk) {
    inside += count;
    if (div <= rounding) free += count;
    squaredDivergence += static_cast<double>(count) * div * div;
    if (!(div > maxDivergence)) return;
    maxDivergence = div;
    at = ijk;
  }
  void addCurl(double squared, std::uint64_t count) {
    curlInside += count;
    squaredCurl += static_cast<double>(count) * squared;
    maxSquaredCurl = std::max(maxSquaredCurl, squared);
  }
  void add(const Sums& s) {
    active += s.active;
    inside += s.inside;
    free += s.free;
    curlInside += s.curlInside;
    squaredDivergence += s.squaredDivergence;
    squaredCurl += s.squaredCurl;
    squaredSpeed += s.squaredSpeed;
    minSquaredSpeed = std::min(minSquaredSpeed, s.minSquaredSpeed);
    maxSquaredSpeed = std::max(maxSquaredSpeed, s.maxSquaredSpeed);
    outflow += s.outflow;
    throughflow += s.throughflow;
    maxSquaredCurl = std::max(maxSquaredCurl, s.maxSquaredCurl);
    if (!(s.maxDivergence > maxDivergence)) return;
    maxDivergence = s.maxDivergence;
    at = s.at;
  }
};

template <typename Vector>
double squaredLength(const Vector& v) {
  return openvdb::Vec3d(v).lengthSqr();
}

/// Speeds, and fluxes through those of a voxel's faces that border on inactive voxels. Collocated
/// values stand for the faces around them.
template <typename Tree>
struct MeasureValues {
  bool staggered;
  Sums* sums;

  void add(const BlockStar<Tree>& star) {
    const LeafMask active = star.active();
    visitBits(active, [&](int n) { sums->addSpeeds(squaredLength(star.own[n]), 1); });
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        if (!star.known[axis][side]) {
          addFluxes(star, axis, side, inner(active, axis, side));
        } else {
          addFluxes(star, axis, side, active);
        }
      }
    }
  }

  void add(const ConstantBox<Tree>& box) {
    const auto size = static_cast<std::uint64_t>(box.size);
    sums->addSpeeds(squaredLength(box.value), size * size * size);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        if (box.on[axis][side] || !box.known[axis][side]) continue;
        const auto& value = staggered && side ? box.sides[axis][side] : box.value;
        sums->addFlux(value[axis], side, static_cast<double>(size * size));
      }
    }
  }

 private:
  /// Without the last layer towards a side.
  static LeafMask inner(LeafMask mask, int axis, int side) {
    for (int x = 0; x < 8; ++x) {
      const int last = side ? 7 : 0;
      if (axis == 0 && x == last) mask[x] = 0;
      if (axis == 1) mask[x] &= ~(std::uint64_t{0xff} << (8 * last));
      if (axis == 2) mask[x] &= ~(std::uint64_t{0x0101010101010101} << last);
    }
    return mask;
  }

  void addFluxes(const BlockStar<Tree>& star, int axis, int side, LeafMask mask) {
    const LeafMask on = star.besideActive(axis, side);
    for (int x = 0; x < 8; ++x) mask[x] &= ~on[x];
    constexpr int kSteps[3] = {64, 8, 1};
    const int step = kSteps[axis];
    visitBits(mask, [&](int n) {
      const bool last = n / step % 8 == 7;
      const auto& value = !(staggered && side) ? star.own[n]
                          : last               ? star.sides[axis][1][n - 7 * step]
                                               : star.own[n + step];
      sums->addFlux(value[axis], side, 1);
    });
  }
};

/// Divergence and curl, by OpenVDB's operators for a map and a scheme.
template <typename Tree, typename Map, typename Divergence, typename Curl>
struct MeasureOperators {
  using Vector = typename Tree::ValueType;
  using Real = typename Vector::value_type;

  const Map& map;
  bool staggered;
  double rounding;  // divergences up to this are none
  Sums* sums;
  PaddedBlock<Vector> padded{};

  void add(const BlockStar<Tree>& star) {
    LeafMask inside = star.active(), curlInside = inside;
    restrict(star.allBesideActive(1), star.allBesideActive(0), &inside, &curlInside);
    const auto empty = [](const LeafMask& mask) {
      for (const std::uint64_t word : mask) {
        if (word) return false;
      }
      return true;
    };
    if (empty(inside) && empty(curlInside)) return;
    padded.fill(star);
    // Of all voxels, in rows: loops without a branch.
    std::array<Real, kVoxelsOfBlock> divergences;
    std::array<double, kVoxelsOfBlock> squaredCurls;
    for (int row = 0; row < 64; ++row) {
      const int first = PaddedBlock<Vector>::place(8 * row);
      for (int z = 0; z < 8; ++z) {
        const auto stencil = padded.stencil(first + z, star.origin.offsetBy(row / 8, row % 8, z));
        divergences[8 * row + z] = Divergence::result(map, stencil);
        squaredCurls[8 * row + z] = squaredLength(Curl::result(map, stencil));
      }
    }
    visitBits(inside, [&](int n) {
      const Coord ijk = star.origin.offsetBy(n / 64, n / 8 % 8, n % 8);
      sums->addDivergence(std::abs(static_cast<double>(divergences[n])), rounding, 1, ijk);
    });
    visitBits(curlInside, [&](int n) { sums->addCurl(squaredCurls[n], 1); });
  }

  /// A box has 27 kinds of voxels: inside, on a facet, on an edge, at a corner.
  void add(const ConstantBox<Tree>& box) {
    for (int kind = 0; kind < 27; ++kind)
      addKind(box, {kind / 9 - 1, kind / 3 % 3 - 1, kind % 3 - 1});
  }

 private:
  template <typename Mask>
  void restrict(const Mask& ahead, const Mask& behind, Mask* inside, Mask* curlInside) const {
    for (int x = 0; x < 8; ++x) {
      (*inside)[x] &= staggered ? ahead[x] : ahead[x] & behind[x];
      (*curlInside)[x] &= staggered ? behind[x] : ahead[x] & behind[x];
    }
  }

  /// @param place  by axis: -1 in the first layer, 1 in the last, else 0
  void addKind(const ConstantBox<Tree>& box, const std::array<int, 3>& place) {
    BoxStencil<Vector> stencil;
    stencil.own = box.value;
    stencil.ijk = box.origin;
    std::uint64_t count = 1;
    bool on[2] = {true, true};
    for (int axis = 0; axis < 3; ++axis) {
      if (place[axis] == 0) count *= static_cast<std::uint64_t>(box.size - 2);
      stencil.ijk[axis] += place[axis] < 0 ? 0 : place[axis] > 0 ? box.size - 1 : 1;
      for (const int side : {0, 1}) {
        const bool out = place[axis] == (side ? 1 : -1);
        stencil.sides[axis][side] = out ? box.sides[axis][side] : box.value;
        on[side] = on[side] && (!out || box.on[axis][side]);
      }
    }
    if (staggered ? on[1] : on[0] && on[1]) {
      const double div = std::abs(static_cast<double>(Divergence::result(map, stencil)));
      sums->addDivergence(div, rounding, count, stencil.ijk);
    }
    if (staggered ? on[0] : on[0] && on[1]) {
      sums->addCurl(squaredLength(Curl::result(map, stencil)), count);
    }
  }
};

/// Sums over all lots, in their order. @param makeVisitor  given where to put a lot's sums
template <typename Tree, typename MakeVisitor>
Sums sumOverLots(const BlockWalk<Tree>& walk, const MakeVisitor& makeVisitor,
                 const Context& context) {
  std::vector<Sums> lots(walk.lotCount());
  parallelFor<std::size_t>(
      lots.size(),
      [&](std::size_t lot) {
        auto visitor = makeVisitor(&lots[lot]);
        walk.visit(lot, &visitor);
      },
      context, 1);
  Sums all;
  for (const Sums& sums : lots) all.add(sums);
  return all;
}

/// Chooses the operators for a grid's map (uniform scale, rotation, ...).
template <typename Tree>
struct SumOperators {
  const BlockWalk<Tree>& walk;
  bool staggered;
  double rounding;
  const Context& context;
  Sums* sums;

  template <typename Map>
  void operator()(const Map& map) const {
    using namespace openvdb::math;
    if (staggered) {
      measure<Map, Divergence<Map, FD_1ST>, Curl<Map, BD_1ST>>(map);
    } else {
      measure<Map, Divergence<Map, CD_2ND>, Curl<Map, CD_2ND>>(map);
    }
  }

  template <typename Map, typename Divergence, typename Curl>
  void measure(const Map& map) const {
    using Visitor = MeasureOperators<Tree, Map, Divergence, Curl>;
    sums->add(sumOverLots(
        walk,
        [&](Sums* lot) {
          return Visitor{map, staggered, rounding, lot};
        },
        context));
  }
};

/// In the units of the certificate. @param voxel  edges of a voxel, world units
Certificate toCertificate(const Sums& s, const openvdb::Vec3d& voxel) {
  Certificate c;
  const double edge = std::min({voxel[0], voxel[1], voxel[2]});
  const double volume = voxel[0] * voxel[1] * voxel[2], area = std::cbrt(volume * volume);
  c.activeVoxels = s.active;
  c.insideVoxels = s.inside;
  c.freeVoxels = s.free;
  for (int k = 0; k < 3; ++k) c.at[k] = s.at[k];
  c.minSpeed = s.active ? std::sqrt(s.minSquaredSpeed) : 0;
  c.maxSpeed = std::sqrt(s.maxSquaredSpeed);
  c.energy = s.squaredSpeed / 2 * volume;
  c.outflow = s.outflow * area;
  c.throughflow = s.throughflow * area;
  const double relative = c.maxSpeed > 0 ? edge / c.maxSpeed : 0;
  const auto rms = [&](double sum, std::uint64_t n) {
    return n ? relative * std::sqrt(sum / static_cast<double>(n)) : 0.0;
  };
  c.rmsDivergence = rms(s.squaredDivergence, s.inside);
  c.rmsCurl = rms(s.squaredCurl, s.curlInside);
  // What is no number is less than nothing; it shows in the sums.
  c.maxDivergence = std::isnan(c.rmsDivergence) ? NAN : relative * s.maxDivergence;
  c.maxCurl = std::isnan(c.rmsCurl) ? NAN : relative * std::sqrt(s.maxSquaredCurl);
  return c;
}

}  // namespace

std::optional<GridPart> partOf(const openvdb::GridBase& grid) {
  return readPart([&](const std::string& name) {
    const openvdb::Metadata::ConstPtr found = grid[name];
    return found ? found->str() : "";
  });
}

bool isStaggered(const openvdb::GridBase& grid) {
  if (grid.getGridClass() == openvdb::GRID_STAGGERED) return true;
  const auto sampling = grid.getMetadata<openvdb::StringMetadata>(kSamplingMetadata);
  return sampling && sampling->value() == "staggered";
}

template <typename Grid>
Certificate measureGrid(const Grid& grid, const Context& context) {
  using Tree = typename Grid::TreeType;
  const bool staggered = isStaggered(grid);
  const openvdb::Vec3d voxel = grid.voxelSize();
  const auto part = partOf(grid);
  // Where a map is not affine, operators give other numbers at other places.
  const BlockWalk<Tree> walk(grid.tree(), part ? part->window : kAllTiles,
                             !grid.transform().isLinear(), context);
  Sums sums = sumOverLots(
      walk,
      [&](Sums* lot) {
        return MeasureValues<Tree>{staggered, lot};
      },
      context);
  const double rounding =
      kFloatDivergence * std::sqrt(sums.maxSquaredSpeed) / std::min({voxel[0], voxel[1], voxel[2]});
  const SumOperators<Tree> measure{walk, staggered, rounding, context, &sums};
  if (!openvdb::math::processTypedMap(grid.transform(), measure)) {
    throw openvdb::TypeError("a transform of type " + grid.transform().mapType());
  }
  Certificate c = toCertificate(sums, voxel);
  c.scheme = staggered ? "FD_1ST" : "CD_2ND";
  c.half = grid.saveFloatAsHalf();
  c.partial = part.has_value();
  return c;
}

template Certificate measureGrid(const openvdb::Vec3SGrid&, const Context&);
template Certificate measureGrid(const openvdb::Vec3DGrid&, const Context&);

}  // namespace octet
