// SPDX-License-Identifier: Apache-2.0
// Slices, their quantities, convolution, scales, and the camera. Whole pictures: golden_test.cpp.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/converters/picture/canvas.h>
#include <octet/converters/picture/lic.h>
#include <octet/converters/picture/picture.h>
#include <octet/core/base/error.h>

namespace octet {
namespace {

/// A field in a ball of radius 2 around (1, 0, -1).
Subject ball(std::function<Vec3(const Vec3&)> field) {
  const Vec3 centre(1, 0, -1);
  Subject subject;
  subject.form = "flow";
  subject.components = 3;
  subject.bounds = {centre - Vec3::Constant(2), centre + Vec3::Constant(2)};
  subject.detail = 0.1;
  subject.sample = [=](const Vec3& p, double* value) {
    if ((p - centre).norm() > 2) return false;
    const Vec3 v = field(p);
    std::copy(v.data(), v.data() + 3, value);
    return true;
  };
  return subject;
}

/// Quadratic, so that central differences are exact.
Vec3 quadratic(const Vec3& p) {
  return {p[0] * p[0] + p[1] * p[2], p[0] * p[1] - 2 * p[2], p[2] * p[2] + 3 * p[0]};
}
double divergence(const Vec3& p) { return 2 * p[0] + p[0] + 2 * p[2]; }
Vec3 curl(const Vec3& p) { return {2, p[1] - 3, p[1] - p[2]}; }

TEST(Slice, PixelsAndPointsAreInverse) {
  for (const int axis : {0, 1, 2}) {
    const SliceGrid grid = fitSlice(ball(quadratic), axis, 0.5, 64, 40);
    EXPECT_EQ(grid.height, 40);
    EXPECT_EQ(grid.width, 40);
    const Vec3 p = grid.point(3, 5);
    EXPECT_EQ(p[axis], 0.5);
    EXPECT_NEAR((grid.pixel(p) - Eigen::Vector2d(3, 5)).norm(), 0, 1e-12);
    // Right and up in the picture, and towards the viewer: right-handed, but for y.
    const Vec3 right = grid.point(4, 5) - p, up = grid.point(3, 4) - p;
    EXPECT_GT(right[grid.rightAxis()], 0);
    EXPECT_GT(up[grid.upAxis()], 0);
    EXPECT_NEAR(right.norm(), grid.spacing, 1e-15);
  }
}

TEST(Slice, OutsideTheBoxIsRefused) {
  const Subject subject = ball(quadratic);
  EXPECT_NO_THROW(fitSlice(subject, 2, -3.0, 10, 10));
  EXPECT_THROW(fitSlice(subject, 2, -3.001, 10, 10), InputError);
  EXPECT_THROW(fitSlice(subject, 0, 3.001, 10, 10), InputError);
  EXPECT_THROW(fitSlice(subject, 0, NAN, 10, 10), InputError);
}

TEST(Slice, QuantitiesAreThoseOfTheField) {
  const Subject subject = ball(quadratic);
  const SliceGrid grid = fitSlice(subject, 2, -0.3, 30, 30);
  const std::vector<std::pair<Quantity, std::function<double(const Vec3&)>>> quantities = {
      {Quantity::Automatic, [](const Vec3& p) { return quadratic(p).norm(); }},
      {Quantity::Magnitude, [](const Vec3& p) { return quadratic(p).norm(); }},
      {Quantity::X, [](const Vec3& p) { return quadratic(p)[0]; }},
      {Quantity::Y, [](const Vec3& p) { return quadratic(p)[1]; }},
      {Quantity::Z, [](const Vec3& p) { return quadratic(p)[2]; }},
      {Quantity::Divergence, divergence},
      {Quantity::Curl, [](const Vec3& p) { return curl(p).norm(); }}};
  for (const auto& [quantity, expected] : quantities) {
    const Slice slice = sampleQuantity(subject, grid, quantity, 0.05);
    int inside = 0;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        if (!slice.isInside(x, y)) continue;
        ++inside;
        EXPECT_NEAR(slice.at(x, y)[0], expected(grid.point(x + 0.5, y + 0.5)), 1e-11)
            << quantityName(quantity);
      }
    }
    EXPECT_GT(inside, 500);
  }
}

TEST(Slice, ScalarsHaveNoComponents) {
  Subject scalar = ball(quadratic);
  scalar.components = 1;
  EXPECT_THROW(checkQuantity(scalar, Quantity::Divergence), InputError);
  EXPECT_THROW(checkQuantity(scalar, Quantity::X), InputError);
  EXPECT_NO_THROW(checkQuantity(scalar, Quantity::Automatic));
  EXPECT_THROW(checkQuantity(Subject{}, Quantity::Automatic), InputError);
}

/// Mean square of differences between neighbours in a direction, over the middle of the picture.
double roughness(const std::vector<float>& texture, int size, int dx, int dy) {
  double sum = 0;
  int count = 0;
  for (int y = size / 4; y < 3 * size / 4; ++y) {
    for (int x = size / 4; x < 3 * size / 4; ++x) {
      const double d = texture[(y + dy) * size + x + dx] - texture[y * size + x];
      sum += d * d;
      ++count;
    }
  }
  return sum / count;
}

TEST(LineIntegralConvolution, SmoothsAlongTheFlowOnly) {
  // Upwards to the right in world, so from the lower left of the picture to the upper right.
  const Subject subject = ball([](const Vec3&) { return Vec3(1, 1, 0); });
  const Slice slice = sampleSlice(subject, fitSlice(subject, 2, {}, 128, 128));
  const std::vector<float> texture = lineIntegralConvolution(slice, 20);
  EXPECT_LT(roughness(texture, 128, 1, -1), 0.05 * roughness(texture, 128, 1, 1));
  double mean = 0, count = 0;
  for (std::size_t k = 0; k < texture.size(); ++k) {
    if (!slice.inside[k]) {
      EXPECT_EQ(texture[k], 0.5f);
      continue;
    }
    mean += texture[k];
    ++count;
  }
  EXPECT_NEAR(mean / count, 0.5, 0.02);
}

TEST(LineIntegralConvolution, DoesNotDependOnThreads) {
  const Subject subject = ball(quadratic);
  const Slice slice = sampleSlice(subject, fitSlice(subject, 1, {}, 90, 90));
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(lineIntegralConvolution(slice, 15));
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(Ticks, AreRoundAndInRange) {
  EXPECT_EQ(niceTicks(0, 1, 5), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(tickLabels(niceTicks(0, 1, 5)),
            (std::vector<std::string>{"0", "0.2", "0.4", "0.6", "0.8", "1"}));
  EXPECT_EQ(tickLabels(niceTicks(-2e-7, 2e-7, 4)),
            (std::vector<std::string>{"-2e-07", "-1e-07", "0", "1e-07", "2e-07"}));
  EXPECT_EQ(tickLabels(niceTicks(1000.1, 1000.5, 4)),
            (std::vector<std::string>{"1000.1", "1000.2", "1000.3", "1000.4", "1000.5"}));
  for (const double max : {1e-300, 3.7e-5, 0.99, 17.0, 8e9, 1e300}) {
    const std::vector<double> ticks = niceTicks(-0.3 * max, max, 6);
    EXPECT_GE(ticks.size(), 3u);
    EXPECT_LE(ticks.size(), 12u);
    EXPECT_GE(ticks.front(), -0.3 * max * (1 + 1e-5));
    EXPECT_LE(ticks.back(), max * (1 + 1e-5));
  }
}

TEST(Colours, MapsEndWhereTheyShouldAndAreMonotonicInLightness) {
  const auto lightness = [](const Vec3& c) {
    return 0.2126 * linearFromSrgb(c[0]) + 0.7152 * linearFromSrgb(c[1]) +
           0.0722 * linearFromSrgb(c[2]);
  };
  for (int k = 0; k < 255; ++k) {
    EXPECT_LT(lightness(colourAt(ColourMap::Viridis, k / 255.0)),
              lightness(colourAt(ColourMap::Viridis, (k + 1) / 255.0)));
  }
  EXPECT_EQ(packColour(colourAt(ColourMap::Viridis, -1)), 0x440154u);
  EXPECT_EQ(packColour(colourAt(ColourMap::Viridis, 2)), 0xfde725u);
  EXPECT_EQ(packColour(colourAt(ColourMap::CoolWarm, 0.5)), 0xddddddu);
  for (double x = 0; x <= 1; x += 0.01) EXPECT_NEAR(srgbFromLinear(linearFromSrgb(x)), x, 1e-6);
}

TEST(Colours, ScaleFollowsTheQuantity) {
  Subject vector = ball(quadratic), scalar = ball(quadratic);
  scalar.components = 1;
  PictureOptions options;
  ColourScale scale = colourScale(vector, options, {2, 5});
  EXPECT_EQ(scale.min, 0);
  EXPECT_EQ(scale.max, 5);
  scale = colourScale(scalar, options, {-2, 5});
  EXPECT_EQ(scale.min, -2);
  EXPECT_EQ(scale.max, 5);
  options.quantity = Quantity::Divergence;
  scale = colourScale(vector, options, {-7, 5});
  EXPECT_EQ(scale.min, -7);
  EXPECT_EQ(scale.max, 7);
  options.range = std::pair(-1.0, 3.0);
  scale = colourScale(vector, options, {-7, 5});
  EXPECT_EQ(scale.min, -1);
  EXPECT_EQ(scale.max, 3);
  // Constants, and nothing at all, still have a range.
  options = {};
  for (const auto& values : std::vector<std::vector<double>>{{3, 3}, {0, 0}, {}}) {
    scale = colourScale(scalar, options, values);
    EXPECT_LT(scale.min, scale.max);
  }
}

TEST(View, SeesAllPointsAndTouchesTheFrame) {
  const std::vector<Vec3> points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 2, 0), Vec3(0.3, 0.2, 3)};
  for (const char up : {'Y', 'Z'}) {
    for (const auto& [width, height] : {std::pair(640, 360), std::pair(200, 500)}) {
      for (const double elevation : {-90.0, -20.0, 0.0, 35.0, 90.0}) {
        for (const double azimuth : {-60.0, 0.0, 130.0}) {
          const View view({azimuth, elevation, 1}, up, points, width, height, 0.8);
          double across = 0, along = 0;
          for (const Vec3& p : points) {
            const Vec3 d = p - view.eye();
            const double depth = -d.dot(view.back());
            EXPECT_GT(depth, 0);
            // The place in the picture whose ray hits the point.
            const double unit = (view.direction(1, 0) - view.direction(0, 0)).dot(view.right());
            across = std::max(across, std::abs(d.dot(view.right()) / depth / unit) / (width / 2.0));
            along = std::max(along, std::abs(d.dot(view.up()) / depth / unit) / (height / 2.0));
          }
          EXPECT_LE(std::max(across, along), 0.8 + 1e-9);
          EXPECT_GE(std::max(across, along), 0.8 - 1e-9);
        }
      }
    }
  }
}

}  // namespace
}  // namespace octet
