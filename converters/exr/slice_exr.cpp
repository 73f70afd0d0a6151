// SPDX-License-Identifier: Apache-2.0
#include "slice_exr.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../io/atomic_file.h"
#include "exr_file.h"

namespace octet {
namespace {

/// An atlas with more pixels than this is refused, for memory.
constexpr double kMostAtlasPixels = 5e8;
/// Parts of one file.
constexpr int kMostSlices = 10000;

/// Letters, digits and what else file readers take for part of a name, not of a path or a layer.
bool isChannelName(const std::string& name) {
  // OpenEXR 1 files, which some programs still read, have names of at most 31 bytes.
  if (name.empty() || name.size() > 31) return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
           c == '-';
  });
}

class SliceWriter {
 public:
  SliceWriter(const Subject& subject, const SliceExrOptions& options, const Context& context)
      : subject_(subject), options_(options), context_(context) {
    checkQuantity(subject, options.quantity);
    if (options.stack < 1 || options.stack > kMostSlices) {
      throw InputError("stack", "is not from 1 to " + std::to_string(kMostSlices));
    }
    if (options.stack > 1 && options.position) {
      throw InputError("stack", "fills the whole domain; the slice's axis takes no position then");
    }
    if (options.width < 1 || options.height < 1)
      throw InputError("picture size", "is not positive");
    whole_ = subject.components == 3 && options.quantity == Quantity::Automatic;
    if (!isChannelName(options.layer)) {
      throw InputError("layer", "\"" + options.layer +
                                    "\" is not a name of letters, digits, _ and -, at most 31");
    }
    spacing_ = options.spacing > 0 ? options.spacing : subject.detail;
    nameChannels();
    for (int k = 0; k < options.stack; ++k) {
      grids_.push_back(fitSlice(subject, options.axis, position(k), options.width, options.height));
    }
  }

  void write(const std::string& path) const {
    if (options_.atlas) {
      writeAtlas(path);
      return;
    }
    std::vector<ExrPart> parts;
    for (std::size_t k = 0; k < grids_.size(); ++k) {
      ExrPart part;
      part.name = partName(k);
      part.width = grids_[k].width;
      part.height = grids_[k].height;
      part.channels = channels_;
      part.attributes = attributes(grids_[k].box());
      part.attributes.push_back({"octet.position", grids_[k].position});
      parts.push_back(std::move(part));
    }
    writeExr(
        parts, [this](std::size_t k) { return pixels(grids_[k]); }, path);
  }

 private:
  std::optional<double> position(int k) const {
    if (options_.stack == 1) return options_.position;
    const Box& box = subject_.bounds;
    return box.min[options_.axis] + (k + 0.5) * sliceSpacing();
  }
  double sliceSpacing() const { return subject_.bounds.size()[options_.axis] / options_.stack; }

  void nameChannels() {
    if (whole_ && options_.rgb) {
      channels_ = {"R", "G", "B"};
    } else if (whole_) {
      for (const char* c : {".X", ".Y", ".Z"}) channels_.push_back(options_.layer + c);
    } else if (options_.quantity != Quantity::Automatic) {
      channels_ = {quantityName(options_.quantity)};
    } else {
      const bool usable = isChannelName(subject_.form) && subject_.form != "A";
      channels_ = {usable ? subject_.form : "Y"};
    }
    channels_.push_back("A");
  }

  /// "z=0.125", with the slice's number where two would read the same.
  std::string partName(std::size_t k) const {
    char text[80];
    std::snprintf(text, sizeof text, "%03zu %c=%.9g", k, "xyz"[options_.axis],
                  grids_[k].position + 0.0);
    return grids_.size() == 1 ? text + 4 : text;
  }

  std::vector<ExrAttribute> attributes(const Box& box) const {
    const SliceGrid& grid = grids_[0];
    const auto axis = [](int k) { return std::string(1, "xyz"[k]); };
    const bool differences =
        options_.quantity == Quantity::Divergence || options_.quantity == Quantity::Curl;
    std::vector<ExrAttribute> result = {
        {"octet.source", subject_.source},
        {"octet.form", subject_.form},
        {"octet.unit", subject_.unit},
        {"octet.axis", axis(grid.axis)},
        {"octet.right", axis(grid.rightAxis())},
        {"octet.up", axis(grid.upAxis())},
        {"octet.spacing", grid.spacing},
        {"octet.worldMin", box.min},
        {"octet.worldMax", box.max},
        {"octet.quantity", std::string(whole_ ? "vector" : quantityName(options_.quantity))}};
    if (subject_.degree) result.push_back({"octet.degree", *subject_.degree});
    if (differences) result.push_back({"octet.differences", spacing_});
    if (options_.stack > 1) result.push_back({"octet.sliceSpacing", sliceSpacing()});
    return result;
  }

  /// Values and A of one of the slices.
  std::vector<float> pixels(const SliceGrid& grid) const {
    const Context part = context_.sub(1.0 / static_cast<double>(grids_.size()));
    const Slice slice = whole_ ? sampleSlice(subject_, grid, part)
                               : sampleQuantity(subject_, grid, options_.quantity, spacing_, part);
    const std::size_t n = static_cast<std::size_t>(slice.components);
    std::vector<float> result;
    result.reserve(slice.inside.size() * (n + 1));
    for (std::size_t p = 0; p < slice.inside.size(); ++p) {
      for (std::size_t c = 0; c < n; ++c) {
        result.push_back(static_cast<float>(slice.values[p * n + c]));
      }
      result.push_back(slice.inside[p] ? 1.0f : 0.0f);
    }
    return result;
  }

  void writeAtlas(const std::string& path) const {
    const SliceGrid& grid = grids_[0];
    const int count = static_cast<int>(grids_.size());
    // About as wide as high.
    const double wanted = std::sqrt(static_cast<double>(count) * grid.height / grid.width);
    const int columns = std::clamp(static_cast<int>(std::lround(wanted)), 1, count);
    const int rows = (count + columns - 1) / columns;
    ExrPart part;
    part.name = "atlas";
    const double size = static_cast<double>(columns) * grid.width * rows * grid.height;
    if (size > kMostAtlasPixels) {
      throw InputError("stack", "the atlas would have more than " +
                                    std::to_string(static_cast<int>(kMostAtlasPixels / 1e6)) +
                                    " million pixels; give a smaller width and height");
    }
    part.width = columns * grid.width;
    part.height = rows * grid.height;
    part.channels = channels_;
    Box box = grid.box();
    std::vector<float> positions;
    for (const SliceGrid& g : grids_) {
      box.extend(g.box().min);
      box.extend(g.box().max);
      positions.push_back(static_cast<float>(g.position));
    }
    part.attributes = attributes(box);
    part.attributes.push_back({"octet.atlasColumns", columns});
    part.attributes.push_back({"octet.atlasRows", rows});
    part.attributes.push_back({"octet.positions", positions});
    const auto atlas = [&](std::size_t) { return atlasPixels(columns, rows); };
    writeExr({part}, atlas, path);
  }

  std::vector<float> atlasPixels(int columns, int rows) const {
    const int w = grids_[0].width, h = grids_[0].height;
    const std::size_t n = channels_.size(), line = n * static_cast<std::size_t>(w);
    std::vector<float> result(line * columns * static_cast<std::size_t>(rows) * h, 0.0f);
    for (std::size_t k = 0; k < grids_.size(); ++k) {
      const std::vector<float> slice = pixels(grids_[k]);
      const std::size_t column = k % static_cast<std::size_t>(columns);
      const std::size_t row = k / static_cast<std::size_t>(columns);
      for (int y = 0; y < h; ++y) {
        std::copy_n(&slice[y * line], line,
                    &result[((row * h + y) * static_cast<std::size_t>(columns) + column) * line]);
      }
    }
    return result;
  }

  const Subject& subject_;
  const SliceExrOptions& options_;
  const Context& context_;
  bool whole_ = false;  // all components of a vector
  double spacing_ = 0;
  std::vector<std::string> channels_;
  std::vector<SliceGrid> grids_;
};

}  // namespace

void writeSliceExr(const Subject& subject, const SliceExrOptions& options, const std::string& path,
                   const Context& context) {
  SliceWriter(subject, options, context).write(path);
}

}  // namespace octet
