// SPDX-License-Identifier: Apache-2.0
#include "measure_grid.h"

#include <cmath>

#include <openvdb/math/Operators.h>
#include <openvdb/tools/GridOperators.h>
#include <openvdb/tree/LeafManager.h>

namespace octet {
namespace {

using openvdb::Coord;

/// Sums and maxima over one leaf.
struct LeafSums {
  std::uint64_t active = 0, inside = 0, free = 0, curlInside = 0;
  double maxDivergence = 0, squaredDivergence = 0, maxCurl = 0, squaredCurl = 0;
  double minSpeed = HUGE_VAL, maxSpeed = 0, squaredSpeed = 0, outflow = 0, throughflow = 0;
  Coord at;
};

template <typename Accessor>
bool allOn(const Accessor& grid, const Coord& ijk, int step) {
  return grid.isValueOn(ijk.offsetBy(step, 0, 0)) && grid.isValueOn(ijk.offsetBy(0, step, 0)) &&
         grid.isValueOn(ijk.offsetBy(0, 0, step));
}

template <typename Grid>
using LeavesOf = openvdb::tree::LeafManager<const typename Grid::TreeType>;

/// Edge and volume of a voxel, world units.
struct VoxelMeasure {
  explicit VoxelMeasure(const openvdb::GridBase& grid) {
    const openvdb::Vec3d size = grid.voxelSize();
    edge = std::min({size[0], size[1], size[2]});
    volume = size[0] * size[1] * size[2];
  }
  double edge, volume;
};

/// Measures the leaves of a grid with the operators for its map (uniform scale, rotation, ...).
template <typename Grid>
struct MeasureOperators {
  const Grid& grid;
  LeavesOf<Grid>* leaves;
  bool staggered;
  double rounding;  // divergences up to this are none
  std::vector<LeafSums>* sums;
  const Context& context;

  template <typename Map>
  void operator()(const Map& map) const {
    if (staggered) {
      measure<openvdb::math::Divergence<Map, openvdb::math::FD_1ST>,
              openvdb::math::Curl<Map, openvdb::math::BD_1ST>>(map);
    } else {
      measure<openvdb::math::Divergence<Map, openvdb::math::CD_2ND>,
              openvdb::math::Curl<Map, openvdb::math::CD_2ND>>(map);
    }
  }

  template <typename Divergence, typename Curl, typename Map>
  void measure(const Map& map) const {
    leaves->foreach ([&](const auto& leaf, std::size_t n) {
      context.poll();
      const auto accessor = grid.getConstAccessor();
      LeafSums& s = (*sums)[n];
      for (auto it = leaf.cbeginValueOn(); it; ++it) {
        const Coord ijk = it.getCoord();
        const bool ahead = allOn(accessor, ijk, 1), behind = allOn(accessor, ijk, -1);
        if (ahead && (staggered || behind)) {
          const double div = std::abs(static_cast<double>(Divergence::result(map, accessor, ijk)));
          ++s.inside;
          if (div <= rounding) ++s.free;
          s.squaredDivergence += div * div;
          if (div > s.maxDivergence) s.at = ijk;
          s.maxDivergence = std::max(s.maxDivergence, div);
        }
        if (behind && (staggered || ahead)) {
          const double curl = openvdb::Vec3d(Curl::result(map, accessor, ijk)).length();
          ++s.curlInside;
          s.squaredCurl += curl * curl;
          s.maxCurl = std::max(s.maxCurl, curl);
        }
      }
    });
  }
};

/// Speeds, and fluxes through those of a voxel's faces that border on inactive voxels. Collocated
/// values stand for the faces around them.
template <typename Grid>
class MeasureValues {
 public:
  MeasureValues(const Grid& grid, bool staggered) : grid_(grid), staggered_(staggered) {}

  void operator()(LeavesOf<Grid>* leaves, std::vector<LeafSums>* sums,
                  const Context& context) const {
    leaves->foreach ([&](const auto& leaf, std::size_t n) {
      context.poll();
      const auto accessor = grid_.getConstAccessor();
      for (auto it = leaf.cbeginValueOn(); it; ++it) {
        add(accessor, it.getCoord(), openvdb::Vec3d(it.getValue()), &(*sums)[n]);
      }
    });
  }

 private:
  template <typename Accessor>
  void add(const Accessor& accessor, const Coord& ijk, const openvdb::Vec3d& value,
           LeafSums* s) const {
    ++s->active;
    const double speed = value.length();
    s->minSpeed = std::min(s->minSpeed, speed);
    s->maxSpeed = std::max(s->maxSpeed, speed);
    s->squaredSpeed += speed * speed;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        Coord next = ijk;
        next[axis] += side;
        if (accessor.isValueOn(next)) continue;
        const double through = staggered_ && side > 0
                                   ? static_cast<double>(accessor.getValue(next)[axis])
                                   : value[axis];
        s->outflow += side * through;
        s->throughflow += std::abs(through);
      }
    }
  }

  const Grid& grid_;
  bool staggered_;
};

/// Sums over the leaves, in their order; divergences as the operators give them.
Certificate sumUp(const std::vector<LeafSums>& sums, const VoxelMeasure& voxel) {
  Certificate c;
  double squaredDivergence = 0, squaredCurl = 0, squaredSpeed = 0, minSpeed = HUGE_VAL;
  std::uint64_t curlInside = 0;
  for (const LeafSums& s : sums) {
    c.activeVoxels += s.active;
    c.insideVoxels += s.inside;
    c.freeVoxels += s.free;
    curlInside += s.curlInside;
    squaredDivergence += s.squaredDivergence;
    squaredCurl += s.squaredCurl;
    squaredSpeed += s.squaredSpeed;
    minSpeed = std::min(minSpeed, s.minSpeed);
    c.maxSpeed = std::max(c.maxSpeed, s.maxSpeed);
    c.outflow += s.outflow;
    c.throughflow += s.throughflow;
    c.maxCurl = std::max(c.maxCurl, s.maxCurl);
    if (s.maxDivergence > c.maxDivergence) {
      c.maxDivergence = s.maxDivergence;
      for (int k = 0; k < 3; ++k) c.at[k] = s.at[k];
    }
  }
  const double area = std::cbrt(voxel.volume * voxel.volume);
  c.minSpeed = c.activeVoxels ? minSpeed : 0;
  c.energy = squaredSpeed / 2 * voxel.volume;
  c.outflow *= area;
  c.throughflow *= area;
  const double relative = c.maxSpeed > 0 ? voxel.edge / c.maxSpeed : 0;
  const auto rms = [](double sum, std::uint64_t n) {
    return n ? std::sqrt(sum / static_cast<double>(n)) : 0.0;
  };
  c.maxDivergence *= relative;
  c.maxCurl *= relative;
  c.rmsDivergence = relative * rms(squaredDivergence, c.insideVoxels);
  c.rmsCurl = relative * rms(squaredCurl, curlInside);
  return c;
}

}  // namespace

bool isStaggered(const openvdb::GridBase& grid) {
  if (grid.getGridClass() == openvdb::GRID_STAGGERED) return true;
  const auto sampling = grid.getMetadata<openvdb::StringMetadata>(kSamplingMetadata);
  return sampling && sampling->value() == "staggered";
}

template <typename Grid>
Certificate measureGrid(const Grid& original, const Context& context) {
  typename Grid::ConstPtr grid = original.copy();  // shares the tree
  if (original.tree().hasActiveTiles()) {
    const auto voxels = original.deepCopy();
    voxels->tree().voxelizeActiveTiles();
    grid = voxels;
  }
  const bool staggered = isStaggered(original);
  LeavesOf<Grid> leaves(grid->tree());
  const VoxelMeasure voxel(*grid);
  std::vector<LeafSums> sums(leaves.leafCount());
  MeasureValues<Grid>(*grid, staggered)(&leaves, &sums, context);
  double maxSpeed = 0;
  for (const LeafSums& s : sums) maxSpeed = std::max(maxSpeed, s.maxSpeed);
  const MeasureOperators<Grid> measure{
      *grid, &leaves, staggered, kFloatDivergence * maxSpeed / voxel.edge, &sums, context};
  if (!openvdb::math::processTypedMap(grid->transform(), measure)) {
    throw openvdb::TypeError("a transform of type " + grid->transform().mapType());
  }
  Certificate c = sumUp(sums, voxel);
  c.scheme = staggered ? "FD_1ST" : "CD_2ND";
  c.half = original.saveFloatAsHalf();
  return c;
}

template Certificate measureGrid(const openvdb::Vec3SGrid&, const Context&);
template Certificate measureGrid(const openvdb::Vec3DGrid&, const Context&);

std::vector<VdbMetadata> toMetadata(const Certificate& c) {
  return {{"octet_divergence_scheme", c.scheme},
          {"octet_divergence_max", c.maxDivergence},
          {"octet_divergence_rms", c.rmsDivergence},
          {"octet_curl_max", c.maxCurl},
          {"octet_curl_rms", c.rmsCurl},
          {"octet_inside_voxels", static_cast<double>(c.insideVoxels)},
          {"octet_divergence_free_voxels", static_cast<double>(c.freeVoxels)},
          {"octet_speed_max", c.maxSpeed},
          {"octet_energy", c.energy},
          {"octet_outflow", c.outflow},
          {"octet_throughflow", c.throughflow}};
}

}  // namespace octet
