// SPDX-License-Identifier: Apache-2.0
#include "picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "../io/atomic_file.h"
#include "slice_picture.h"
#include "solid_picture.h"

namespace octet {
namespace {

bool isSigned(Quantity quantity) {
  return quantity == Quantity::X || quantity == Quantity::Y || quantity == Quantity::Z ||
         quantity == Quantity::Divergence;
}

void checkOptions(const PictureOptions& options) {
  if (options.width < 1 || options.height < 1) {
    throw InputError("picture size", "is not positive");
  }
  if (options.range && !(options.range->first < options.range->second)) {
    throw InputError("range", "its first number is not less than the second");
  }
  if (options.spacing < 0 || !std::isfinite(options.spacing)) {
    throw InputError("spacing", "is not a positive number");
  }
}

}  // namespace

void writePicture(const Subject& subject, const PictureOptions& options, const std::string& path,
                  const Context& context) {
  checkOptions(options);
  const AtomicFile trial(path);  // before work is put into it
  if (options.view == PictureView::Slice) {
    if (std::filesystem::path(path).extension() == ".exr") {
      throw InputError(path, "", "a drawn slice is written as .png");
    }
    drawSlice(subject, options, path, context);
  } else {
    drawSolid(subject, options, path, context);
  }
}

ColourScale colourScale(const Subject& subject, const PictureOptions& options,
                        const std::vector<double>& values) {
  double min = HUGE_VAL, max = -HUGE_VAL;
  for (const double v : values) {
    min = std::min(min, v);
    max = std::max(max, v);
  }
  if (!(min <= max)) min = max = 0;
  const bool scalar = subject.components == 1;
  ColourScale scale;
  if (isSigned(options.quantity)) {
    scale.map = ColourMap::CoolWarm;
    scale.max = std::max(std::abs(min), std::abs(max));
    scale.min = -scale.max;
  } else {
    scale.min = scalar ? min : 0;
    scale.max = max;
  }
  if (options.range) {
    scale.min = options.range->first;
    scale.max = options.range->second;
  }
  // A constant gets a range around it, so that rounding is not blown up to colours.
  const double size = std::max(std::abs(scale.min), std::abs(scale.max));
  if (!(scale.max - scale.min > 1e-9 * size)) {
    scale.min -= size > 0 ? size / 2 : 1;
    scale.max += size > 0 ? size / 2 : 1;
  }
  return scale;
}

std::string quantityLabel(const Subject& subject, Quantity quantity) {
  const std::string& name = subject.form;
  std::string label;
  switch (quantity) {
    case Quantity::Automatic:
      label = subject.components == 3 ? "|" + name + "|" : name;
      break;
    case Quantity::Magnitude:
      label = "|" + name + "|";
      break;
    case Quantity::X:
    case Quantity::Y:
    case Quantity::Z:
      label = name + "." + quantityName(quantity);
      break;
    case Quantity::Divergence:
      label = "div " + name;
      break;
    case Quantity::Curl:
      label = "|curl " + name + "|";
  }
  return label;
}

std::string pictureTitle(const Subject& subject, const PictureOptions& options) {
  if (!options.title.empty()) return options.title;
  std::string title = subject.source;
  if (!subject.form.empty() && subject.form != subject.source) {
    title += (title.empty() ? "" : ": ") + subject.form;
  }
  return title;
}

}  // namespace octet
