// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <octet/core/base/types.h>

#include "colour_map.h"

namespace octet {

/// Pixels in sRGB, 0xRRGGBB, row by row from the top.
struct Raster {
  int width = 0, height = 0;
  std::vector<std::uint32_t> pixels;

  std::uint32_t& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  std::uint32_t at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// 0xRRGGBB of a colour of 0 to 1 each.
std::uint32_t packColour(const Vec3& srgb);

/// @brief Drawing with Cairo: lines, arrows, text, and PNG. Places are in pixels from the upper
/// left corner, pixel centres at halves. Not thread safe.
class Canvas {
 public:
  using Point = Eigen::Vector2d;
  enum class Align { Left, Centre, Right };

  Canvas(int width, int height, const Vec3& background);
  explicit Canvas(const Raster& raster);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  int width() const;
  int height() const;

  /// Copies pixels, the raster's upper left corner to (x, y).
  void paste(const Raster& raster, int x, int y);
  void line(const Point& from, const Point& to, double thickness, const Vec3& colour,
            double opacity = 1);
  void rectangle(const Point& from, const Point& to, double thickness, const Vec3& colour);
  void fill(const Point& from, const Point& to, const Vec3& colour);
  /// An arrow with a head in proportion, and a thin halo that sets it off any ground.
  void arrow(const Point& from, const Point& to, double thickness, const Vec3& colour,
             const Vec3& halo);
  /// Text with its middle line at `at`, in the system's sans serif.
  void text(const Point& at, const std::string& text, double size, const Vec3& colour,
            Align align = Align::Left);
  double textWidth(const std::string& text, double size);

  Raster raster() const;
  /// Writes a PNG; it appears complete or not at all. @throws IoError
  void writePng(const std::string& path) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Round numbers that divide a range into about `count` parts, ascending.
std::vector<double> niceTicks(double min, double max, int count);

/// Numbers as a scale shows them: as many digits as the ticks' distance asks for.
std::vector<std::string> tickLabels(const std::vector<double>& ticks);

/// A vertical colour bar with ticks and, with labels, numbers on its right and a name above.
void drawColourBar(Canvas* canvas, const ColourScale& scale, const Canvas::Point& from,
                   const Canvas::Point& to, const std::string& name, double textSize, bool labels);

}  // namespace octet
