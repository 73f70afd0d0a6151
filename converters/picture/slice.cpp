// SPDX-License-Identifier: Apache-2.0
#include "slice.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <octet/core/base/reported_loop.h>

namespace octet {
namespace {

/// Rows between two reports.
constexpr int kBand = 32;

/// Calls `pixel(x, y)` for all pixels, in parallel, reporting bands of rows.
void forPixels(const SliceGrid& grid, const Context& context,
               const std::function<void(int, int)>& pixel) {
  for (int first = 0; first < grid.height; first += kBand) {
    context.report({"sample slice", static_cast<std::size_t>(first),
                    static_cast<std::size_t>(grid.height), "rows"});
    const int rows = std::min(kBand, grid.height - first);
    parallelFor<int>(
        rows * grid.width, [&](int k) { pixel(k % grid.width, first + k / grid.width); }, context,
        256);
  }
  const auto all = static_cast<std::size_t>(grid.height);
  context.report({"sample slice", all, all, "rows"});
}

Slice emptySlice(const SliceGrid& grid, int components) {
  const std::size_t pixels = static_cast<std::size_t>(grid.width) * grid.height;
  Slice slice;
  slice.grid = grid;
  slice.components = components;
  slice.values.assign(pixels * components, 0);
  slice.inside.assign(pixels, 0);
  return slice;
}

/// Jacobian by central differences: entry (i, k) is the change of component i along axis k.
bool jacobian(const Subject& subject, const Vec3& p, double h, Eigen::Matrix3d* result) {
  for (int k = 0; k < 3; ++k) {
    Vec3 after, before;
    if (!subject.sample(p + h * Vec3::Unit(k), after.data()) ||
        !subject.sample(p - h * Vec3::Unit(k), before.data())) {
      return false;
    }
    result->col(k) = (after - before) / (2 * h);
  }
  return true;
}

bool quantityAt(const Subject& subject, Quantity quantity, double h, const Vec3& p,
                double* result) {
  Vec3 v;
  if (!subject.sample(p, v.data())) return false;
  switch (quantity) {
    case Quantity::Automatic:
      *result = subject.components == 3 ? v.norm() : v[0];
      return true;
    case Quantity::Magnitude:
      *result = v.norm();
      return true;
    case Quantity::X:
    case Quantity::Y:
    case Quantity::Z:
      *result = v[static_cast<int>(quantity) - static_cast<int>(Quantity::X)];
      return true;
    case Quantity::Divergence:
    case Quantity::Curl:
      break;
  }
  Eigen::Matrix3d j;
  if (!jacobian(subject, p, h, &j)) return false;
  if (quantity == Quantity::Divergence) {
    *result = j.trace();
  } else {
    *result = Vec3(j(2, 1) - j(1, 2), j(0, 2) - j(2, 0), j(1, 0) - j(0, 1)).norm();
  }
  return true;
}

}  // namespace

const char* quantityName(Quantity quantity) {
  constexpr const char* kNames[] = {"value", "magnitude", "x", "y", "z", "divergence", "curl"};
  return kNames[static_cast<int>(quantity)];
}

Vec3 SliceGrid::point(double x, double y) const {
  Vec3 p;
  p[axis] = position;
  p[rightAxis()] = left + x * spacing;
  p[upAxis()] = top - y * spacing;
  return p;
}

Eigen::Vector2d SliceGrid::pixel(const Vec3& p) const {
  return {(p[rightAxis()] - left) / spacing, (top - p[upAxis()]) / spacing};
}

Box SliceGrid::box() const {
  Box result;
  result.extend(point(0, 0));
  result.extend(point(width, height));
  return result;
}

SliceGrid fitSlice(const Subject& subject, int axis, std::optional<double> position, int width,
                   int height) {
  const Box& box = subject.bounds;
  SliceGrid grid;
  grid.axis = axis;
  grid.position = position.value_or((box.min[axis] + box.max[axis]) / 2);
  if (!(grid.position >= box.min[axis] && grid.position <= box.max[axis])) {
    std::ostringstream reason;
    reason << grid.position << " lies outside the domain, which reaches from " << box.min[axis]
           << " to " << box.max[axis];
    throw InputError(std::string("slice ") + "xyz"[axis], reason.str());
  }
  const Vec3 size = box.size();
  const int right = grid.rightAxis(), up = grid.upAxis();
  grid.spacing = std::max(size[right] / width, size[up] / height);
  if (!(grid.spacing > 0) || !std::isfinite(grid.spacing)) {
    throw InputError("slice", "the domain is flat or too large");
  }
  const auto pixels = [&](int k, int most) {
    // Rounding must not add a pixel.
    return std::clamp(static_cast<int>(std::ceil(size[k] / grid.spacing - 1e-9)), 1, most);
  };
  grid.width = pixels(right, width);
  grid.height = pixels(up, height);
  grid.left = (box.min[right] + box.max[right] - grid.width * grid.spacing) / 2;
  grid.top = (box.min[up] + box.max[up] + grid.height * grid.spacing) / 2;
  return grid;
}

Slice sampleSlice(const Subject& subject, const SliceGrid& grid, const Context& context) {
  checkQuantity(subject, Quantity::Automatic);
  Slice slice = emptySlice(grid, subject.components);
  forPixels(grid, context, [&](int x, int y) {
    const std::size_t k = static_cast<std::size_t>(y) * grid.width + x;
    slice.inside[k] =
        subject.sample(grid.point(x + 0.5, y + 0.5), &slice.values[k * slice.components]);
  });
  return slice;
}

Slice sampleQuantity(const Subject& subject, const SliceGrid& grid, Quantity quantity,
                     double spacing, const Context& context) {
  checkQuantity(subject, quantity);
  Slice slice = emptySlice(grid, 1);
  forPixels(grid, context, [&](int x, int y) {
    const std::size_t k = static_cast<std::size_t>(y) * grid.width + x;
    slice.inside[k] =
        quantityAt(subject, quantity, spacing, grid.point(x + 0.5, y + 0.5), &slice.values[k]);
  });
  return slice;
}

void checkQuantity(const Subject& subject, Quantity quantity) {
  if (subject.components == 0) throw InputError("", "there is no form to draw");
  if (subject.components == 1 && quantity != Quantity::Automatic) {
    throw InputError("quantity", std::string(quantityName(quantity)) + " needs a vector, but \"" +
                                     subject.form + "\" is a scalar");
  }
}

}  // namespace octet
