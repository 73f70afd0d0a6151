// SPDX-License-Identifier: Apache-2.0
// Whole pictures against golden ones in tests/data/golden; without text, so that fonts play no
// part. To renew them after a change that is meant: OCTETVDB_WRITE_GOLDEN=1 golden_test, and look
// at them.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <cairo.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/converters/picture/canvas.h>
#include <octet/converters/picture/picture.h>
#include <octet/core/base/error.h>

#include "tests/support/test_data.h"

namespace octet {
namespace {

namespace fs = std::filesystem;

Raster readPng(const std::string& path) {
  cairo_surface_t* const surface = cairo_image_surface_create_from_png(path.c_str());
  Raster raster;
  if (cairo_surface_status(surface) == CAIRO_STATUS_SUCCESS) {
    raster.width = cairo_image_surface_get_width(surface);
    raster.height = cairo_image_surface_get_height(surface);
    const unsigned char* const data = cairo_image_surface_get_data(surface);
    for (int y = 0; y < raster.height; ++y) {
      const auto* row = reinterpret_cast<const std::uint32_t*>(
          data + static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(surface));
      for (int x = 0; x < raster.width; ++x) raster.pixels.push_back(row[x] & 0xffffffu);
    }
  }
  cairo_surface_destroy(surface);
  return raster;
}

/// How far two pictures are apart. Of a pixel, the largest difference of its channels counts, 0 to
/// 255.
struct Difference {
  double mean = 0;  ///< over all pixels
  double far = 0;   ///< part of the pixels that differ by more than 32
};

Difference compare(const Raster& a, const Raster& b) {
  if (a.width != b.width || a.height != b.height || a.pixels.empty()) return {255, 1};
  Difference result;
  for (std::size_t k = 0; k < a.pixels.size(); ++k) {
    int most = 0;
    for (const int shift : {0, 8, 16}) {
      most = std::max(most, std::abs(static_cast<int>(a.pixels[k] >> shift & 255) -
                                     static_cast<int>(b.pixels[k] >> shift & 255)));
    }
    result.mean += most;
    result.far += most > 32 ? 1 : 0;
  }
  result.mean /= static_cast<double>(a.pixels.size());
  result.far /= static_cast<double>(a.pixels.size());
  return result;
}

/// The stated tolerance: rounding differs between processors and versions of Cairo and Embree.
bool same(const Difference& d) { return d.mean <= 0.25 && d.far <= 0.001; }

std::ostream& operator<<(std::ostream& os, const Difference& d) {
  return os << "mean " << d.mean << ", far " << d.far;
}

/// The box sample, and options for pictures of it.
const Subject& box() {
  static const Subject subject = [] {
    AssetSubjectOptions options;
    options.levels = 2;
    return assetSubject(readControlAsset(testing::testData("../../samples/box/box.octet.json")),
                        options);
  }();
  return subject;
}

PictureOptions base() {
  PictureOptions options;
  options.width = 400;
  options.height = 300;
  options.labels = false;
  return options;
}
PictureOptions licSlice() {
  PictureOptions options = base();
  options.style = PictureStyle::Lic;
  options.axis = 1;
  return options;
}
PictureOptions arrowsSlice() {
  PictureOptions options = base();
  options.style = PictureStyle::Arrows;
  options.axis = 0;
  options.position = 0.25;
  return options;
}
PictureOptions streamlines3d() {
  PictureOptions options = base();
  options.view = PictureView::Solid;
  options.style = PictureStyle::Streamlines;
  options.count = 30;
  return options;
}

std::string temporary(const std::string& name) {
  return (fs::path(::testing::TempDir()) / ("octet_golden_" + name)).string();
}

Raster draw(const PictureOptions& options) {
  const std::string path = temporary("picture.png");
  writePicture(box(), options, path);
  const Raster raster = readPng(path);
  fs::remove(path);
  return raster;
}

void checkGolden(const std::string& name, const PictureOptions& options,
                 const std::vector<PictureOptions>& changed) {
  const std::string path = testing::testData("golden/" + name + ".png");
  if (std::getenv("OCTETVDB_WRITE_GOLDEN")) writePicture(box(), options, path);
  const Raster golden = readPng(path);
  ASSERT_FALSE(golden.pixels.empty()) << path;
  const Raster now = draw(options);
  const Difference difference = compare(golden, now);
  EXPECT_TRUE(same(difference)) << difference;
  if (!same(difference)) Canvas(now).writePng(temporary(name + ".png"));
  // The tolerance must not hide a change that is seen.
  for (std::size_t k = 0; k < changed.size(); ++k) {
    const Difference other = compare(golden, draw(changed[k]));
    EXPECT_FALSE(same(other)) << name << " changed in way " << k << ": " << other;
  }
}

TEST(Golden, LicSlice) {
  std::vector<PictureOptions> changed(3, licSlice());
  changed[0].position = 0.05;
  changed[1].style = PictureStyle::Plain;
  changed[2].range = std::pair(0.0, 1.5);
  checkGolden("lic_slice", licSlice(), changed);
}

TEST(Golden, ArrowsSlice) {
  std::vector<PictureOptions> changed(3, arrowsSlice());
  changed[0].position = 0.3;
  changed[1].style = PictureStyle::Plain;
  changed[2].quantity = Quantity::Curl;
  checkGolden("arrows_slice", arrowsSlice(), changed);
}

TEST(Golden, Streamlines3d) {
  std::vector<PictureOptions> changed(4, streamlines3d());
  changed[0].camera.azimuth += 1;
  changed[1].count = 29;
  changed[2].surface = false;
  changed[3].mesh = false;
  checkGolden("streamlines_3d", streamlines3d(), changed);
}

TEST(Picture, BytesDoNotDependOnThreads) {
  for (PictureOptions options : {licSlice(), arrowsSlice(), streamlines3d()}) {
    options.labels = true;
    std::vector<std::string> files;
    for (const int threads : {1, 2, 7}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const std::string path = temporary("threads.png");
      writePicture(box(), options, path);
      std::ifstream stream(path, std::ios::binary);
      files.push_back({std::istreambuf_iterator<char>(stream), {}});
      fs::remove(path);
    }
    EXPECT_GT(files[0].size(), 1000u);
    EXPECT_EQ(files[0], files[1]);
    EXPECT_EQ(files[0], files[2]);
  }
}

/// Tells whether a report says something new: long steps repeat theirs.
class News {
 public:
  bool operator()(const ProgressReport& report) {
    const bool same = report.stage == last_.stage && report.done == last_.done;
    last_ = report;
    return !same;
  }

 private:
  ProgressReport last_;
};

TEST(Picture, CancelledAtAnyReportLeavesNothing) {
  const fs::path folder = temporary("cancelled");
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (PictureOptions options : {licSlice(), streamlines3d()}) {
    options.width = 160;
    options.height = 120;
    int total = 0;
    const auto count = [&, news = News()](const ProgressReport& report) mutable {
      EXPECT_LE(report.done, report.total);
      total += news(report);
      return true;
    };
    writePicture(box(), options, (folder / "whole.png").string(), count);
    fs::remove(folder / "whole.png");
    EXPECT_GT(total, 5);
    for (int stop = 1; stop <= total; stop += std::max(1, total / 5)) {
      int left = stop;
      const auto cut = [&, news = News()](const ProgressReport& report) mutable {
        left -= news(report);
        return left > 0;
      };
      EXPECT_THROW(writePicture(box(), options, (folder / "cut.png").string(), cut), Cancelled);
      EXPECT_TRUE(fs::is_empty(folder));
    }
  }
  fs::remove_all(folder);
}

TEST(Picture, TinyHugeAndFarDomainsLookTheSame) {
  // A power of two, so that the numbers are the same ones.
  const double scale = std::ldexp(1, -40);
  for (const PictureOptions& options : {arrowsSlice(), streamlines3d()}) {
    Subject small = box();
    small.bounds.min *= scale;
    small.bounds.max *= scale;
    small.detail *= scale;
    small.sample = [scale](const Vec3& p, double* value) { return box().sample(p / scale, value); };
    for (auto* lines : {&small.shape.cage, &small.shape.mesh}) {
      for (auto& line : *lines) {
        for (Vec3& p : line) p *= scale;
      }
    }
    for (Vec3& p : small.shape.points) p *= scale;
    PictureOptions scaled = options;
    if (scaled.position) *scaled.position *= scale;
    const std::string path = temporary("small.png");
    writePicture(small, scaled, path);
    const Difference difference = compare(draw(options), readPng(path));
    EXPECT_TRUE(same(difference)) << difference;
    fs::remove(path);
  }
}

TEST(Picture, WhatCannotBeDrawnIsRefused) {
  const std::string path = temporary("refused.png");
  const auto refused = [&](const Subject& subject, const PictureOptions& options) {
    EXPECT_THROW(writePicture(subject, options, path), InputError);
    EXPECT_FALSE(fs::exists(path));
  };
  PictureOptions options = base();
  options.style = PictureStyle::Streamlines;
  refused(box(), options);
  options = streamlines3d();
  options.style = PictureStyle::Lic;
  refused(box(), options);
  options = base();
  options.width = 20;
  refused(box(), options);
  options.width = 0;
  refused(box(), options);
  options.width = 40000;
  refused(box(), options);
  options = base();
  options.range = std::pair(1.0, 1.0);
  refused(box(), options);
  Subject scalar = box();
  scalar.components = 1;
  refused(scalar, licSlice());
  refused(scalar, arrowsSlice());
  refused(scalar, streamlines3d());
  refused(Subject{}, base());
  refused(Subject{}, streamlines3d());
  EXPECT_THROW(writePicture(box(), base(), temporary("missing") + "/a.png"), IoError);
}

}  // namespace
}  // namespace octet
