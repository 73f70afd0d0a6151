// SPDX-License-Identifier: Apache-2.0
#include "slice_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <octet/core/base/parallel.h>

#include "lic.h"

namespace octet {
namespace {

const Vec3 kPaper(1, 1, 1), kInk(0.15, 0.15, 0.15), kOutside(0.93, 0.93, 0.93);

/// Sizes for a picture 720 pixels high; others in proportion.
constexpr double kDesignHeight = 720;
constexpr double kTextSize = 15, kTitleSize = 18;
constexpr double kTitleRoom = 54, kRoomBelow = 46, kRoomLeft = 74, kMargin = 16;
constexpr double kBarGap = 26, kBarWidth = 20, kBarRoom = 100;
constexpr int kAxisTicks = 6;
constexpr double kTickLength = 5;
/// Arrows stand this far apart. Lengths are in proportion to the vectors, such that this part of
/// them is no longer than the distance (a few fast places must not make all others points), but the
/// longest not more than so many distances. That is cut off, so that arrows do not overlap.
constexpr double kArrowSpacing = 26, kUsual = 0.9, kMostUnusual = 3, kLongestArrow = 1.1,
                 kArrowThickness = 1.7;
/// Arrows shorter than this, in pixels, are left out.
constexpr double kShortestArrow = 2;
/// Reach of the convolution and how much of the brightness it modulates.
constexpr double kLicReach = 26, kLicDepth = 0.62;
/// Pixels along each side that are averaged to one.
constexpr int kSubsamples = 2;

/// Where the parts of a picture are, in pixels.
struct Layout {
  double scale;  // of design sizes
  int plotX, plotY, plotWidth, plotHeight;
  double barX, barTop, barBottom;
};

/// The plot as large as fits, plot and bar centred together.
Layout layOut(const Subject& subject, const PictureOptions& options) {
  Layout l;
  l.scale = std::min(options.width / (kDesignHeight * 16 / 9), options.height / kDesignHeight);
  l.scale = std::max(l.scale, 0.5);
  const double s = l.scale;
  const bool labels = options.labels;
  const double above = labels ? kTitleRoom * s : kMargin * s;
  const double below = labels ? kRoomBelow * s : kMargin * s;
  const double left = labels ? kRoomLeft * s : kMargin * s;
  const double right = (kBarGap + kBarWidth + (labels ? kBarRoom : kMargin)) * s;
  const int width = static_cast<int>(options.width - left - right);
  const int height = static_cast<int>(options.height - above - below);
  if (width < 1 || height < 1) {
    throw InputError("picture size", std::to_string(options.width) + " x " +
                                         std::to_string(options.height) +
                                         " leaves no room for the slice");
  }
  const SliceGrid grid = fitSlice(subject, options.axis, options.position, width, height);
  l.plotWidth = grid.width;
  l.plotHeight = grid.height;
  l.plotX = static_cast<int>(left) + (width - grid.width) / 2;
  l.plotY = static_cast<int>(above) + (height - grid.height) / 2;
  l.barX = l.plotX + grid.width + kBarGap * s;
  l.barTop = l.plotY + (labels ? 2 * kTextSize * s : 0);
  l.barBottom = l.plotY + grid.height;
  return l;
}

/// Colours of fine pixels averaged in light; outside the domain the ground.
Raster colours(const Slice& fine, const ColourScale& scale, const std::vector<float>& brightness) {
  const int n = kSubsamples;
  Raster raster{fine.grid.width / n, fine.grid.height / n, {}};
  raster.pixels.resize(static_cast<std::size_t>(raster.width) * raster.height);
  parallelFor<int>(
      raster.height,
      [&](int y) {
        for (int x = 0; x < raster.width; ++x) {
          Vec3 sum = Vec3::Zero();
          for (int k = 0; k < n * n; ++k) {
            const int i = n * x + k % n, j = n * y + k / n;
            Vec3 colour = fine.isInside(i, j) ? scale.at(fine.at(i, j)[0]) : kOutside;
            if (!brightness.empty() && fine.isInside(i, j)) {
              const double b = brightness[static_cast<std::size_t>(y) * raster.width + x];
              // Below 1/2 towards black, above towards white.
              const double t = kLicDepth * (2 * b - 1);
              colour =
                  t < 0 ? Vec3((1 + t) * colour) : Vec3(colour + t * 0.6 * (Vec3::Ones() - colour));
            }
            for (int c = 0; c < 3; ++c) sum[c] += linearFromSrgb(colour[c]);
          }
          for (double& c : sum) c = srgbFromLinear(c / (n * n));
          raster.at(x, y) = packColour(sum);
        }
      },
      1);
  return raster;
}

/// Arrows on a triangular lattice, their lengths in proportion to the vectors' part in the plane.
void drawArrows(const Subject& subject, const SliceGrid& grid, const Layout& l, Canvas* canvas) {
  const double spacing = kArrowSpacing * l.scale;
  struct Arrow {
    Canvas::Point at, vector;
  };
  std::vector<Arrow> arrows;
  std::vector<double> lengths;
  const double rowHeight = spacing * std::sqrt(0.75);
  const int rows = std::max(1, static_cast<int>(grid.height / rowHeight));
  for (int row = 0; row < rows; ++row) {
    const double y = (row + 0.5) * grid.height / rows;
    const int columns = std::max(1, static_cast<int>(grid.width / spacing));
    for (int column = 0; column <= columns; ++column) {
      const double x = (column + (row % 2 ? 0.75 : 0.25)) * grid.width / columns;
      if (x >= grid.width) continue;
      Vec3 v;
      if (!subject.sample(grid.point(x, y), v.data())) continue;
      const Canvas::Point flat(v[grid.rightAxis()], -v[grid.upAxis()]);
      arrows.push_back({{l.plotX + x, l.plotY + y}, flat});
      lengths.push_back(flat.norm());
    }
  }
  if (arrows.empty()) return;
  std::sort(lengths.begin(), lengths.end());
  const double usual =
      std::max(lengths[static_cast<std::size_t>(kUsual * static_cast<double>(lengths.size() - 1))],
               lengths.back() / kMostUnusual);
  if (!(usual > 0)) return;
  for (const Arrow& arrow : arrows) {
    Canvas::Point half = arrow.vector / usual * spacing / 2;
    if (2 * half.norm() < kShortestArrow) continue;
    half *= std::min(1.0, kLongestArrow * spacing / (2 * half.norm()));
    canvas->arrow(arrow.at - half, arrow.at + half, kArrowThickness * l.scale, {1, 1, 1},
                  {0.05, 0.05, 0.05});
  }
}

void drawAxes(const SliceGrid& grid, const Layout& l, bool labels, Canvas* canvas) {
  const double s = l.scale, left = l.plotX, top = l.plotY;
  const double right = left + l.plotWidth, bottom = top + l.plotHeight;
  canvas->rectangle({left - 0.5, top - 0.5}, {right + 0.5, bottom + 0.5}, 1, kInk);
  const Box box = grid.box();
  for (const bool across : {true, false}) {
    const int axis = across ? grid.rightAxis() : grid.upAxis();
    const std::vector<double> ticks = niceTicks(box.min[axis], box.max[axis], kAxisTicks);
    const std::vector<std::string> numbers = tickLabels(ticks);
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      Vec3 p = box.min;
      p[axis] = ticks[k];
      const Eigen::Vector2d at = grid.pixel(p);
      if (across) {
        const double x = left + at[0];
        canvas->line({x, bottom}, {x, bottom + kTickLength * s}, 1, kInk);
        if (labels) {
          canvas->text({x, bottom + 16 * s}, numbers[k], kTextSize * s, kInk,
                       Canvas::Align::Centre);
        }
      } else {
        const double y = top + at[1];
        canvas->line({left - kTickLength * s, y}, {left, y}, 1, kInk);
        if (labels) {
          canvas->text({left - 10 * s, y}, numbers[k], kTextSize * s, kInk, Canvas::Align::Right);
        }
      }
    }
    if (!labels) continue;
    const std::string name(1, "xyz"[axis]);
    if (across) {
      canvas->text({(left + right) / 2, bottom + 34 * s}, name, kTextSize * s, kInk,
                   Canvas::Align::Centre);
    } else {
      canvas->text({left - 56 * s, (top + bottom) / 2}, name, kTextSize * s, kInk,
                   Canvas::Align::Centre);
    }
  }
}

std::string sliceTitle(const Subject& subject, const PictureOptions& options,
                       const SliceGrid& grid) {
  std::string title = pictureTitle(subject, options);
  if (!options.title.empty()) return title;
  char place[64];
  std::snprintf(place, sizeof place, ", %c = %.4g", "xyz"[grid.axis], grid.position + 0.0);
  return title + place;
}

std::vector<double> insideValues(const Slice& slice) {
  std::vector<double> values;
  for (std::size_t k = 0; k < slice.inside.size(); ++k) {
    if (slice.inside[k]) values.push_back(slice.values[k]);
  }
  return values;
}

}  // namespace

void drawSlice(const Subject& subject, const PictureOptions& options, const std::string& path,
               const Context& context) {
  checkQuantity(subject, options.quantity);
  const bool lines = options.style == PictureStyle::Lic || options.style == PictureStyle::Arrows;
  if (options.style == PictureStyle::Streamlines) {
    throw InputError("style", "streamlines are drawn in the 3d view; in a slice take lic");
  }
  if (lines && subject.components != 3) {
    throw InputError("style",
                     "lic and arrows need a vector, but \"" + subject.form + "\" is a scalar");
  }
  const Layout l = layOut(subject, options);
  const SliceGrid grid =
      fitSlice(subject, options.axis, options.position, l.plotWidth, l.plotHeight);
  SliceGrid fineGrid = grid;
  fineGrid.width *= kSubsamples;
  fineGrid.height *= kSubsamples;
  fineGrid.spacing /= kSubsamples;
  const double spacing = options.spacing > 0 ? options.spacing : subject.detail;
  const Slice fine = sampleQuantity(subject, fineGrid, options.quantity, spacing, context.sub(0.4));
  const ColourScale scale = colourScale(subject, options, insideValues(fine));
  std::vector<float> brightness;
  if (options.style == PictureStyle::Lic) {
    brightness = lineIntegralConvolution(sampleSlice(subject, grid, context.sub(0.1)),
                                         kLicReach * l.scale, context);
  }
  Canvas canvas(options.width, options.height, kPaper);
  canvas.paste(colours(fine, scale, brightness), l.plotX, l.plotY);
  if (options.style == PictureStyle::Arrows) drawArrows(subject, grid, l, &canvas);
  drawAxes(grid, l, options.labels, &canvas);
  drawColourBar(&canvas, scale, {l.barX, l.barTop}, {l.barX + kBarWidth * l.scale, l.barBottom},
                quantityLabel(subject, options.quantity), kTextSize * l.scale, options.labels);
  if (options.labels) {
    canvas.text({options.width / 2.0, l.plotY - kTitleRoom * l.scale / 2},
                sliceTitle(subject, options, grid), kTitleSize * l.scale, kInk,
                Canvas::Align::Centre);
  }
  canvas.writePng(path);
}

}  // namespace octet
