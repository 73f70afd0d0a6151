// SPDX-License-Identifier: Apache-2.0
#include "canvas.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <cairo.h>

#include <octet/core/base/error.h>

#include "../io/atomic_file.h"

namespace octet {
namespace {

/// Of an arrow's shaft: width and length of the head in thicknesses.
constexpr double kHeadWidth = 4.2, kHeadLength = 5;
/// A short arrow is all head from here on, in lengths.
constexpr double kLongestHead = 0.6;
constexpr double kHalo = 1.0;  // pixels
/// Largest side of a Cairo image.
constexpr int kLargestSide = 32767;

/// Distance of a scale's numbers from the bar, and length of its ticks, in text sizes.
constexpr double kTickGap = 0.7, kTickLength = 0.35;
constexpr int kBarTicks = 6;

void check(cairo_status_t status) {
  if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  if (status != CAIRO_STATUS_SUCCESS) throw Error("", "Cairo", cairo_status_to_string(status));
}

cairo_status_t appendBytes(void* closure, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

std::uint32_t packColour(const Vec3& srgb) {
  std::uint32_t result = 0;
  for (int c = 0; c < 3; ++c) {
    result =
        result << 8 | static_cast<std::uint32_t>(std::lround(std::clamp(srgb[c], 0.0, 1.0) * 255));
  }
  return result;
}

struct Canvas::State {
  State(int width, int height) {
    if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
      throw InputError("picture size", std::to_string(width) + " x " + std::to_string(height) +
                                           " is out of range; sides can be 1 to " +
                                           std::to_string(kLargestSide));
    }
    surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
    check(cairo_surface_status(surface));
    context = cairo_create(surface);
    check(cairo_status(context));
  }
  ~State() {
    cairo_destroy(context);
    cairo_surface_destroy(surface);
  }
  void colour(const Vec3& c, double opacity = 1) const {
    cairo_set_source_rgba(context, c[0], c[1], c[2], opacity);
  }

  cairo_surface_t* surface = nullptr;
  cairo_t* context = nullptr;
};

Canvas::Canvas(int width, int height, const Vec3& background)
    : state_(std::make_unique<State>(width, height)) {
  state_->colour(background);
  cairo_paint(state_->context);
  cairo_set_line_cap(state_->context, CAIRO_LINE_CAP_BUTT);
  cairo_set_line_join(state_->context, CAIRO_LINE_JOIN_ROUND);
  cairo_font_options_t* const options = cairo_font_options_create();
  // The same text wherever the canvas is shown.
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(state_->context, options);
  cairo_font_options_destroy(options);
  cairo_select_font_face(state_->context, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
}

Canvas::Canvas(const Raster& raster) : Canvas(raster.width, raster.height, Vec3::Ones()) {
  paste(raster, 0, 0);
}

Canvas::~Canvas() = default;

int Canvas::width() const { return cairo_image_surface_get_width(state_->surface); }
int Canvas::height() const { return cairo_image_surface_get_height(state_->surface); }

void Canvas::paste(const Raster& raster, int x, int y) {
  cairo_surface_flush(state_->surface);
  unsigned char* const data = cairo_image_surface_get_data(state_->surface);
  const int stride = cairo_image_surface_get_stride(state_->surface);
  const int from = std::max(0, -x), to = std::min(raster.width, width() - x);
  for (int row = std::max(0, -y); row < std::min(raster.height, height() - y); ++row) {
    if (from >= to) break;
    std::memcpy(data + static_cast<std::ptrdiff_t>(row + y) * stride + 4 * (x + from),
                &raster.pixels[static_cast<std::size_t>(row) * raster.width + from],
                4 * static_cast<std::size_t>(to - from));
  }
  cairo_surface_mark_dirty(state_->surface);
}

void Canvas::line(const Point& from, const Point& to, double thickness, const Vec3& colour,
                  double opacity) {
  state_->colour(colour, opacity);
  cairo_set_line_width(state_->context, thickness);
  cairo_move_to(state_->context, from[0], from[1]);
  cairo_line_to(state_->context, to[0], to[1]);
  cairo_stroke(state_->context);
}

void Canvas::rectangle(const Point& from, const Point& to, double thickness, const Vec3& colour) {
  state_->colour(colour);
  cairo_set_line_width(state_->context, thickness);
  cairo_rectangle(state_->context, from[0], from[1], to[0] - from[0], to[1] - from[1]);
  cairo_stroke(state_->context);
}

void Canvas::fill(const Point& from, const Point& to, const Vec3& colour) {
  state_->colour(colour);
  cairo_rectangle(state_->context, from[0], from[1], to[0] - from[0], to[1] - from[1]);
  cairo_fill(state_->context);
}

void Canvas::arrow(const Point& from, const Point& to, double thickness, const Vec3& colour,
                   const Vec3& halo) {
  const double length = (to - from).norm();
  if (!(length > 0)) return;
  const Point along = (to - from) / length, across(-along[1], along[0]);
  const double head = std::min(kHeadLength * thickness, kLongestHead * length);
  const double half = head * kHeadWidth / kHeadLength / 2;
  const double shaft = std::min(thickness, half) / 2;
  const Point neck = to - head * along;
  cairo_t* const c = state_->context;
  const auto move = [&](const Point& p) { cairo_line_to(c, p[0], p[1]); };
  cairo_new_path(c);
  move(from + shaft * across);
  move(neck + shaft * across);
  move(neck + half * across);
  move(to);
  move(neck - half * across);
  move(neck - shaft * across);
  move(from - shaft * across);
  cairo_close_path(c);
  state_->colour(halo, 0.6);
  cairo_set_line_width(c, 2 * kHalo);
  cairo_stroke_preserve(c);
  state_->colour(colour);
  cairo_fill(c);
}

void Canvas::text(const Point& at, const std::string& text, double size, const Vec3& colour,
                  Align align) {
  cairo_set_font_size(state_->context, size);
  cairo_font_extents_t font;
  cairo_font_extents(state_->context, &font);
  const double part = align == Align::Left ? 0 : align == Align::Centre ? 0.5 : 1;
  state_->colour(colour);
  cairo_move_to(state_->context, at[0] - part * textWidth(text, size),
                at[1] + (font.ascent - font.descent) / 2);
  cairo_show_text(state_->context, text.c_str());
  check(cairo_status(state_->context));
}

double Canvas::textWidth(const std::string& text, double size) {
  cairo_set_font_size(state_->context, size);
  cairo_text_extents_t extents;
  cairo_text_extents(state_->context, text.c_str(), &extents);
  check(cairo_status(state_->context));
  return extents.x_advance;
}

Raster Canvas::raster() const {
  cairo_surface_flush(state_->surface);
  Raster result{width(), height(), {}};
  result.pixels.resize(static_cast<std::size_t>(result.width) * result.height);
  const unsigned char* const data = cairo_image_surface_get_data(state_->surface);
  const int stride = cairo_image_surface_get_stride(state_->surface);
  for (int y = 0; y < result.height; ++y) {
    std::memcpy(&result.at(0, y), data + static_cast<std::ptrdiff_t>(y) * stride,
                4 * static_cast<std::size_t>(result.width));
  }
  for (std::uint32_t& pixel : result.pixels) pixel &= 0xffffffu;
  return result;
}

void Canvas::writePng(const std::string& path) const {
  AtomicFile file(path);
  std::string bytes;
  check(cairo_surface_write_to_png_stream(state_->surface, appendBytes, &bytes));
  errno = 0;
  std::ofstream stream(file.temporaryPath(), std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    throw IoError(path, std::string("cannot be written: ") +
                            (errno ? std::strerror(errno) : "the disk may be full"));
  }
  file.commit();
}

std::vector<double> niceTicks(double min, double max, int count) {
  if (!(max > min)) return {min};
  const double rough = (max - min) / count;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  // The nearest, as ratios go.
  double step = power;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (std::abs(std::log(factor * power / rough)) < std::abs(std::log(step / rough))) {
      step = factor * power;
    }
  }
  // Whole multiples of the step; a little beyond the ends, for rounding.
  const double first = std::ceil(min / step - 1e-6), last = std::floor(max / step + 1e-6);
  std::vector<double> ticks;
  for (double k = first; k <= last && ticks.size() < 100; ++k) ticks.push_back(k * step + 0.0);
  return ticks;
}

std::vector<std::string> tickLabels(const std::vector<double>& ticks) {
  double largest = 0;
  for (const double t : ticks) largest = std::max(largest, std::abs(t));
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : largest;
  // Digits from the first of the largest to the first of the step.
  const int digits = step > 0 ? std::clamp(static_cast<int>(std::floor(std::log10(largest)) -
                                                            std::floor(std::log10(step) + 1e-9)) +
                                               1,
                                           1, 12)
                              : 1;
  std::vector<std::string> result;
  for (const double t : ticks) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", ticks.size() > 1 ? digits : 4, t);
    result.push_back(text);
  }
  return result;
}

void drawColourBar(Canvas* canvas, const ColourScale& scale, const Canvas::Point& from,
                   const Canvas::Point& to, const std::string& name, double textSize, bool labels) {
  const Vec3 ink = Vec3::Constant(0.15);
  const int x = static_cast<int>(std::lround(from[0])), y = static_cast<int>(std::lround(from[1]));
  Raster bar{std::max(1, static_cast<int>(std::lround(to[0])) - x),
             std::max(1, static_cast<int>(std::lround(to[1])) - y),
             {}};
  bar.pixels.resize(static_cast<std::size_t>(bar.width) * bar.height);
  for (int row = 0; row < bar.height; ++row) {
    const std::uint32_t colour = packColour(colourAt(scale.map, 1 - (row + 0.5) / bar.height));
    for (int column = 0; column < bar.width; ++column) bar.at(column, row) = colour;
  }
  canvas->paste(bar, x, y);
  const double right = x + bar.width, bottom = y + bar.height;
  canvas->rectangle({x + 0.0, y + 0.0}, {right, bottom}, 1, ink);
  const std::vector<double> ticks = niceTicks(scale.min, scale.max, kBarTicks);
  const std::vector<std::string> numbers = tickLabels(ticks);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double part =
        scale.max > scale.min ? (ticks[k] - scale.min) / (scale.max - scale.min) : 0.5;
    const double at = bottom - part * bar.height;
    canvas->line({right, at}, {right + kTickLength * textSize, at}, 1, ink);
    if (labels) canvas->text({right + kTickGap * textSize, at}, numbers[k], textSize, ink);
  }
  if (labels) canvas->text({x + 0.0, y - 1.3 * textSize}, name, textSize, ink);
}

}  // namespace octet
