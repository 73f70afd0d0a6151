// SPDX-License-Identifier: Apache-2.0
#include "solid_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "../exr/exr_file.h"
#include "canvas.h"

namespace octet {
namespace {

const Vec3 kInk(0.15, 0.15, 0.15);
constexpr double kDesignHeight = 720;
constexpr double kTextSize = 15, kTitleSize = 18, kTitlePlace = 30;
/// The colour bar at the right edge.
constexpr double kBarRight = 104, kBarWidth = 18, kBarHeight = 300;
/// Part of the picture that the domain may fill.
constexpr double kRoom = 0.84;

/// Adds the background and encodes for display.
Raster develop(const RenderedImage& image, const Vec3& background) {
  Raster raster{image.width, image.height, {}};
  raster.pixels.resize(image.pixels.size());
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    const auto& pixel = image.pixels[k];
    Vec3 colour;
    for (int c = 0; c < 3; ++c) {
      colour[c] = srgbFromLinear(pixel[c] + (1 - pixel[3]) * background[c]);
    }
    raster.pixels[k] = packColour(colour);
  }
  return raster;
}

void drawLabels(const Subject& subject, const PictureOptions& options,
                const std::optional<ColourScale>& scale, Canvas* canvas) {
  const double s = std::max(
      0.5, std::min(options.width / (kDesignHeight * 16 / 9), options.height / kDesignHeight));
  if (options.labels) {
    canvas->text({options.width / 2.0, kTitlePlace * s}, pictureTitle(subject, options),
                 kTitleSize * s, kInk, Canvas::Align::Centre);
  }
  if (!scale || options.width < 2 * kBarRight * s || options.height < 1.2 * kBarHeight * s) return;
  const double left = options.width - kBarRight * s;
  const double top = (options.height - kBarHeight * s) / 2;
  drawColourBar(canvas, *scale, {left, top}, {left + kBarWidth * s, top + kBarHeight * s},
                quantityLabel(subject, Quantity::Automatic), kTextSize * s, options.labels);
}

/// The rendered light itself.
void writeLight(const RenderedImage& image, const Subject& subject, const std::string& path) {
  ExrPart part;
  part.name = "light";
  part.width = image.width;
  part.height = image.height;
  part.channels = {"R", "G", "B", "A"};
  part.attributes = {{"octet.source", subject.source}, {"octet.form", subject.form}};
  const auto pixels = [&](std::size_t) {
    std::vector<float> values;
    values.reserve(4 * image.pixels.size());
    for (const auto& pixel : image.pixels) values.insert(values.end(), pixel.begin(), pixel.end());
    return values;
  };
  writeExr({part}, pixels, path);
}

}  // namespace

void drawSolid(const Subject& subject, const PictureOptions& options, const std::string& path,
               const Context& context) {
  Canvas canvas(options.width, options.height, Vec3::Ones());  // refuses sizes that are too large
  const SolidScene solid = buildScene(subject, options, context.sub(0.4));
  const View view(options.camera, subject.upAxis, solid.extent, options.width, options.height,
                  kRoom);
  const RenderedImage image = render(solid.scene, view, options.width, options.height, context);
  if (std::filesystem::path(path).extension() == ".exr") {
    writeLight(image, subject, path);
    return;
  }
  canvas.paste(develop(image, solid.scene.background), 0, 0);
  drawLabels(subject, options, solid.scale, &canvas);
  canvas.writePng(path);
}

}  // namespace octet
