// SPDX-License-Identifier: Apache-2.0
// What is measured of a vector grid, against OpenVDB's own operators and accessors, voxel by voxel.
#include <cstdio>
#include <random>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/math/Operators.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/GridOperators.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <octet/converters/vdb/block_walk.h>
#include <octet/converters/vdb/grid_stencils.h>
#include <octet/converters/vdb/measure_grid.h>

namespace octet {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

/// How a grid's voxels lie in space.
enum class Lie { Uniform, Stretched, Rotated, Frustum };

openvdb::math::Transform::Ptr transformOf(Lie lie) {
  using openvdb::math::Transform;
  if (lie == Lie::Frustum) {
    return Transform::createFrustumTransform(openvdb::BBoxd({-64, -64, -64}, {320, 320, 320}),
                                             /*taper=*/0.5, /*depth=*/1.5);
  }
  const auto transform = Transform::createLinearTransform(0.25);
  if (lie == Lie::Stretched) transform->postScale(openvdb::Vec3d(1, 2, 0.5));
  if (lie == Lie::Rotated) transform->postRotate(0.7, openvdb::math::Z_AXIS);
  transform->postTranslate(openvdb::Vec3d(1, 2, 3));
  return transform;
}

struct Case {
  Lie lie = Lie::Uniform;
  bool staggered = false;
  bool largeTile = false;  ///< one of 128^3 voxels, too
};

/// Leaves that are full, part active or empty, tiles that are active or not, beside one another and
/// across the borders of larger nodes, on a background that is not 0.
template <typename Grid>
typename Grid::Ptr randomGrid(const Case& test, std::uint32_t seed) {
  using Value = typename Grid::ValueType;
  using Real = typename Value::value_type;
  std::mt19937 random(seed);
  std::uniform_real_distribution<Real> number(-1, 1);
  const auto value = [&] { return Value(number(random), number(random), number(random)); };
  auto grid = Grid::create(value());
  grid->setTransform(transformOf(test.lie));
  if (test.staggered) grid->setGridClass(openvdb::GRID_STAGGERED);
  auto& tree = grid->tree();
  if (test.largeTile) tree.fill(CoordBBox(Coord(0), Coord(127)), value(), true);
  // Around a corner of nodes of 128 and of 4096 voxels.
  for (int leaf = 0; leaf < 180; ++leaf) {
    Coord origin;
    for (int k = 0; k < 3; ++k) origin[k] = 8 * (static_cast<int>(random() % 6) - 3);
    const CoordBBox box(origin, origin.offsetBy(7));
    switch (random() % 4) {
      case 0:
        tree.fill(box, value(), true);
        break;
      case 1:
        tree.fill(box, value(), random() % 2 != 0);
        break;
      default: {
        const bool full = random() % 2 != 0;
        for (auto at = box.begin(); at; ++at) {
          if (full || random() % 3) tree.setValue(*at, value());
          if (!full && random() % 5 == 0) tree.setValueOff(*at, value());
        }
      }
    }
  }
  // A tile of one value with its neighbours, so that there are boxes alike.
  const Value same = value();
  tree.fill(CoordBBox(Coord(-64), Coord(-33)), same, true);
  return grid;
}

/// All sums over the voxels of a grid, one after the other, by accessors.
template <typename Grid, typename Map>
class Reference {
 public:
  Reference(const Grid& original, const Map& map) : map_(map) {
    grid_ = original.deepCopy();
    grid_->tree().voxelizeActiveTiles();
    staggered_ = original.getGridClass() == openvdb::GRID_STAGGERED;
    voxel_ = original.voxelSize();
    c_.minSpeed = HUGE_VAL;
    for (auto it = grid_->cbeginValueOn(); it; ++it) addValue(it.getCoord(), it.getValue());
    const double edge = std::min({voxel_[0], voxel_[1], voxel_[2]});
    rounding_ = kFloatDivergence * c_.maxSpeed / edge;
    for (auto it = grid_->cbeginValueOn(); it; ++it) addOperators(it.getCoord());
    const double volume = voxel_.product(), area = std::cbrt(volume * volume);
    c_.energy *= volume;
    c_.outflow *= area;
    c_.throughflow *= area;
    const double relative = edge / c_.maxSpeed;
    c_.maxDivergence *= relative;
    c_.maxCurl *= relative;
    c_.rmsDivergence =
        relative * std::sqrt(c_.rmsDivergence / static_cast<double>(c_.insideVoxels));
    c_.rmsCurl = relative * std::sqrt(c_.rmsCurl / static_cast<double>(curlInside_));
  }

  const Certificate& certificate() const { return c_; }

  double divergence(const Coord& ijk) const {
    using openvdb::math::Divergence;
    const auto accessor = grid_->getConstAccessor();
    return staggered_ ? Divergence<Map, openvdb::math::FD_1ST>::result(map_, accessor, ijk)
                      : Divergence<Map, openvdb::math::CD_2ND>::result(map_, accessor, ijk);
  }
  openvdb::Vec3d curl(const Coord& ijk) const {
    using openvdb::math::Curl;
    const auto accessor = grid_->getConstAccessor();
    return staggered_
               ? openvdb::Vec3d(Curl<Map, openvdb::math::BD_1ST>::result(map_, accessor, ijk))
               : openvdb::Vec3d(Curl<Map, openvdb::math::CD_2ND>::result(map_, accessor, ijk));
  }
  bool inside(const Coord& ijk) const { return allOn(ijk, 1) && (staggered_ || allOn(ijk, -1)); }
  bool curlInside(const Coord& ijk) const {
    return allOn(ijk, -1) && (staggered_ || allOn(ijk, 1));
  }

 private:
  bool allOn(const Coord& ijk, int step) const {
    const auto& tree = grid_->tree();
    return tree.isValueOn(ijk.offsetBy(step, 0, 0)) && tree.isValueOn(ijk.offsetBy(0, step, 0)) &&
           tree.isValueOn(ijk.offsetBy(0, 0, step));
  }

  void addValue(const Coord& ijk, const openvdb::Vec3d& value) {
    ++c_.activeVoxels;
    c_.minSpeed = std::min(c_.minSpeed, value.length());
    c_.maxSpeed = std::max(c_.maxSpeed, value.length());
    c_.energy += value.lengthSqr() / 2;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        Coord next = ijk;
        next[axis] += side;
        if (grid_->tree().isValueOn(next)) continue;
        const double through =
            staggered_ && side > 0 ? grid_->tree().getValue(next)[axis] : value[axis];
        c_.outflow += side * through;
        c_.throughflow += std::abs(through);
      }
    }
  }

  void addOperators(const Coord& ijk) {
    if (inside(ijk)) {
      const double div = std::abs(divergence(ijk));
      ++c_.insideVoxels;
      if (div <= rounding_) ++c_.freeVoxels;
      c_.maxDivergence = std::max(c_.maxDivergence, div);
      c_.rmsDivergence += div * div;
    }
    if (curlInside(ijk)) {
      const double size = curl(ijk).length();
      ++curlInside_;
      c_.maxCurl = std::max(c_.maxCurl, size);
      c_.rmsCurl += size * size;
    }
  }

  const Map& map_;
  typename Grid::Ptr grid_;
  bool staggered_ = false;
  openvdb::Vec3d voxel_;
  double rounding_ = 0;
  std::uint64_t curlInside_ = 0;
  Certificate c_;
};

/// Compares every voxel of every block with what OpenVDB says there.
template <typename Grid, typename Map>
struct CompareVoxels {
  using Tree = typename Grid::TreeType;
  using Vector = typename Grid::ValueType;

  const Reference<Grid, Map>& reference;
  const Map& map;
  bool staggered;
  std::uint64_t voxels = 0, boxVoxels = 0, different = 0;
  PaddedBlock<Vector> padded{};

  void add(const BlockStar<Tree>& star) {
    padded.fill(star);
    LeafMask inside = star.allBesideActive(1), curlInside = star.allBesideActive(0);
    if (!staggered) {
      for (int x = 0; x < 8; ++x) inside[x] = curlInside[x] = inside[x] & curlInside[x];
    }
    visitBits(star.active(), [&](int n) {
      const Coord ijk = star.origin.offsetBy(n / 64, n / 8 % 8, n % 8);
      compare(ijk, padded.stencil(PaddedBlock<Vector>::place(n), ijk), has(inside, n),
              has(curlInside, n));
    });
  }
  /// Only counted here: their sums are compared.
  void add(const ConstantBox<Tree>& box) {
    boxVoxels += static_cast<std::uint64_t>(box.size) * static_cast<std::uint64_t>(box.size) *
                 static_cast<std::uint64_t>(box.size);
  }

 private:
  static bool has(const LeafMask& mask, int n) { return mask[n / 64] >> (n % 64) & 1; }

  template <typename Stencil>
  void compare(const Coord& ijk, const Stencil& stencil, bool inside, bool curlInside) {
    using namespace openvdb::math;
    ++voxels;
    different += inside != reference.inside(ijk) || curlInside != reference.curlInside(ijk);
    const double div = staggered ? Divergence<Map, FD_1ST>::result(map, stencil)
                                 : Divergence<Map, CD_2ND>::result(map, stencil);
    const auto curl = staggered ? Curl<Map, BD_1ST>::result(map, stencil)
                                : Curl<Map, CD_2ND>::result(map, stencil);
    different += div != reference.divergence(ijk) || openvdb::Vec3d(curl) != reference.curl(ijk);
  }
};

void expectSame(const Certificate& found, const Certificate& expected, double maxDivergence) {
  EXPECT_EQ(found.activeVoxels, expected.activeVoxels);
  EXPECT_EQ(found.insideVoxels, expected.insideVoxels);
  EXPECT_EQ(found.freeVoxels, expected.freeVoxels);
  EXPECT_EQ(found.maxDivergence, expected.maxDivergence);
  EXPECT_EQ(found.minSpeed, expected.minSpeed);
  EXPECT_EQ(found.maxSpeed, expected.maxSpeed);
  EXPECT_DOUBLE_EQ(found.maxCurl, expected.maxCurl);
  EXPECT_DOUBLE_EQ(maxDivergence, expected.maxDivergence);
  const auto nearly = [](double a, double b) { return std::abs(a - b) <= 1e-11 * std::abs(b); };
  EXPECT_PRED2(nearly, found.rmsDivergence, expected.rmsDivergence);
  EXPECT_PRED2(nearly, found.rmsCurl, expected.rmsCurl);
  EXPECT_PRED2(nearly, found.energy, expected.energy);
  EXPECT_PRED2(nearly, found.throughflow, expected.throughflow);
  EXPECT_NEAR(found.outflow, expected.outflow, 1e-11 * expected.throughflow);
}

template <typename Grid>
struct Compare {
  const Grid& grid;
  const Case& test;

  template <typename Map>
  void operator()(const Map& map) const {
    using Tree = typename Grid::TreeType;
    const Reference<Grid, Map> reference(grid, map);
    const Certificate found = measureGrid(grid);
    ASSERT_GT(found.insideVoxels, 1000u);
    ASSERT_GT(found.activeVoxels, found.insideVoxels);
    const openvdb::Vec3d voxel = grid.voxelSize();
    const double relative = std::min({voxel[0], voxel[1], voxel[2]}) / found.maxSpeed;
    const Coord at(found.at[0], found.at[1], found.at[2]);
    expectSame(found, reference.certificate(), relative * std::abs(reference.divergence(at)));
    const Context context;
    const BlockWalk<Tree> walk(grid.tree(), kAllTiles, test.lie == Lie::Frustum, context);
    CompareVoxels<Grid, Map> voxels{reference, map, test.staggered};
    for (std::size_t lot = 0; lot < walk.lotCount(); ++lot) walk.visit(lot, &voxels);
    EXPECT_EQ(voxels.different, 0u);
    EXPECT_EQ(voxels.voxels + voxels.boxVoxels, found.activeVoxels);
    EXPECT_GT(voxels.voxels, 10000u);
    EXPECT_GT(voxels.boxVoxels, 1000u);
  }
};

template <typename Grid>
void compareWithOpenVdb(const Case& test, std::uint32_t seed) {
  openvdb::initialize();
  const auto grid = randomGrid<Grid>(test, seed);
  const Compare<Grid> compare{*grid, test};
  ASSERT_TRUE(openvdb::math::processTypedMap(grid->transform(), compare));
}

TEST(Certificate, IsWhatOpenVdbsOperatorsFind) {
  std::uint32_t seed = 1;
  for (const Lie lie : {Lie::Uniform, Lie::Stretched, Lie::Rotated, Lie::Frustum}) {
    for (const bool staggered : {false, true}) {
      SCOPED_TRACE("lie " + std::to_string(static_cast<int>(lie)) +
                   (staggered ? " staggered" : ""));
      compareWithOpenVdb<openvdb::Vec3SGrid>({lie, staggered}, seed++);
      compareWithOpenVdb<openvdb::Vec3DGrid>({lie, staggered}, seed++);
    }
  }
}

TEST(Certificate, LargeTilesBesideLeavesAreMeasuredAsTiles) {
  for (const bool staggered : {false, true}) {
    compareWithOpenVdb<openvdb::Vec3SGrid>({Lie::Uniform, staggered, true}, 40);
  }
}

TEST(Certificate, DoesNotDependOnThreads) {
  openvdb::initialize();
  const auto grid = randomGrid<openvdb::Vec3SGrid>({Lie::Uniform, true}, 50);
  const auto measured = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return measureGrid(*grid);
  };
  const Certificate one = measured(1), two = measured(2);
  EXPECT_EQ(one.rmsDivergence, two.rmsDivergence);
  EXPECT_EQ(one.rmsCurl, two.rmsCurl);
  EXPECT_EQ(one.energy, two.energy);
  EXPECT_EQ(one.outflow, two.outflow);
  EXPECT_EQ(one.at, two.at);
}

TEST(Certificate, WhatIsNoNumberShows) {
  openvdb::initialize();
  auto grid = openvdb::Vec3SGrid::create();
  grid->tree().fill(CoordBBox(Coord(0), Coord(20)), openvdb::Vec3s(1, 0, 0), true);
  EXPECT_EQ(measureGrid(*grid).maxDivergence, 0);
  grid->tree().setValue(Coord(10), openvdb::Vec3s(NAN, 0, 0));
  EXPECT_TRUE(std::isnan(measureGrid(*grid).maxDivergence));
}

TEST(Certificate, LooksAtFewPlacesOfATileAndStopsWhenAsked) {
  openvdb::initialize();
  auto grid = openvdb::Vec3SGrid::create();
  constexpr std::uint64_t kSide = 16384;
  grid->tree().fill(CoordBBox(Coord(0), Coord(kSide - 1)), openvdb::Vec3s(0, 0, 2), true);
  const Certificate c = measureGrid(*grid);
  EXPECT_EQ(c.activeVoxels, kSide * kSide * kSide);
  EXPECT_EQ(c.insideVoxels, (kSide - 2) * (kSide - 2) * (kSide - 2));
  EXPECT_EQ(c.freeVoxels, c.insideVoxels);
  EXPECT_EQ(c.maxDivergence, 0);
  EXPECT_EQ(c.throughflow, 2.0 * 2 * kSide * kSide);
  EXPECT_EQ(c.outflow, 0);
  ContextParts parts;
  int polls = 0;
  parts.stop = [&] { return ++polls > 3; };
  const Context context(std::move(parts));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_THROW(measureGrid(*grid, context), Cancelled);
}

TEST(Certificate, ReadingAFileStopsWhenAsked) {
  openvdb::initialize();
  const auto grid = randomGrid<openvdb::Vec3SGrid>({Lie::Uniform, false}, 60);
  grid->setName("velocity");
  const std::string path =
      ::testing::TempDir() + "octet_certificate_test_" + std::to_string(::getpid()) + ".vdb";
  openvdb::io::File(path).write({grid});
  int most = 0;
  const auto measured = [&](int polls) {
    ContextParts parts;
    int seen = 0;
    parts.stop = [&] { return most = ++seen, seen > polls; };
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return verifyVdb(path, "", Context(std::move(parts))).at(0).certificate;
  };
  EXPECT_EQ(measured(1 << 30).activeVoxels, grid->activeVoxelCount());
  const int all = most;
  EXPECT_GT(all, 20);
  for (const int polls : {0, 1, 2, all / 2, all - 1}) EXPECT_THROW(measured(polls), Cancelled);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace octet
