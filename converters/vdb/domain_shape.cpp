// SPDX-License-Identifier: Apache-2.0
#include "domain_shape.h"

#include <cmath>

#include <octet/core/topology/control_mesh.h>
#include <octet/core/topology/domain_box.h>

namespace octet {
namespace {

/// Part of bin `k` that a range covers; bins are of length 1, from 0 on.
double covered(double from, double to, int k) {
  return std::max(0.0, std::min(to, k + 1.0) - std::max(from, static_cast<double>(k)));
}

}  // namespace

Box turnedBox(const Box& box, const AxisTurn& turn) {
  Box turned;
  turned.extend(turn(box.min));
  turned.extend(turn(box.max));
  return turned;
}

DomainShape::DomainShape(const Complex& complex, const Array<Vec3>& positions,
                         const AxisTurn& turn) {
  const Array<Vec3> x = turn(positions);
  box_ = domainBox(complex, x);
  bins_.assign(std::size_t{kBins} * kBins * kBins, 0.0);
  for (Index cell = 0; cell < complex.cellCount(); ++cell) {
    Box box;
    for (int i = 0; i < complex.cellVertexCount(cell); ++i) {
      box.extend(x[complex.cellVertex(cell, i)]);
    }
    addCell(box, std::abs(cellVolume6(complex, x, cell)) / 6);
  }
  for (Index f = 0; f < complex.facetCount(); ++f) {
    if (!complex.facetOnBoundary(f)) continue;
    const auto [a, b, c] = complex.facetVertices(f);
    shadow_ += (x[b] - x[a]).cross(x[c] - x[a]).cwiseAbs() / 4;
  }
}

/// As if the cell filled its box evenly.
void DomainShape::addCell(const Box& cell, double volume) {
  volume_ += volume;
  int first[3], last[3];
  Vec3 from, to;
  for (int k = 0; k < 3; ++k) {
    from[k] = (cell.min[k] - box_.min[k]) / binEdge(k);
    to[k] = std::max((cell.max[k] - box_.min[k]) / binEdge(k), from[k] + 1e-9);
    first[k] = std::clamp(static_cast<int>(from[k]), 0, kBins - 1);
    last[k] = std::clamp(static_cast<int>(to[k]), 0, kBins - 1);
  }
  const double density = volume / (to - from).prod();
  for (int i = first[0]; i <= last[0]; ++i) {
    for (int j = first[1]; j <= last[1]; ++j) {
      const double column = density * covered(from[0], to[0], i) * covered(from[1], to[1], j);
      for (int k = first[2]; k <= last[2]; ++k) {
        bins_[(static_cast<std::size_t>(i) * kBins + j) * kBins + k] +=
            column * covered(from[2], to[2], k);
      }
    }
  }
}

double DomainShape::cubes(double spacing, double edge) const {
  if (box_.empty()) return 0;
  return (volume_ + edge * (shadow_.sum() + edge * (box_.size().sum() + edge))) /
         (spacing * spacing * spacing);
}

/// Volume in a box by bins along an axis; what the box leaves of a bin along it is not taken off.
std::array<double, DomainShape::kBins> DomainShape::profile(const Box& box, int axis) const {
  std::array<double, kBins> sums{};
  std::array<std::array<double, kBins>, 3> parts;
  for (int k = 0; k < 3; ++k) {
    const double from = (box.min[k] - box_.min[k]) / binEdge(k);
    const double to = (box.max[k] - box_.min[k]) / binEdge(k);
    for (int bin = 0; bin < kBins; ++bin) parts[k][bin] = k == axis ? 1 : covered(from, to, bin);
  }
  std::size_t n = 0;
  for (int i = 0; i < kBins; ++i) {
    for (int j = 0; j < kBins; ++j) {
      for (int k = 0; k < kBins; ++k, ++n) {
        const int at[3] = {i, j, k};
        sums[at[axis]] += bins_[n] * parts[0][i] * parts[1][j] * parts[2][k];
      }
    }
  }
  return sums;
}

double DomainShape::share(const Box& box) const {
  if (!(volume_ > 0)) return 0;
  const auto sums = profile(box, 0);
  const double from = (box.min[0] - box_.min[0]) / binEdge(0);
  const double to = (box.max[0] - box_.min[0]) / binEdge(0);
  double sum = 0;
  for (int bin = 0; bin < kBins; ++bin) sum += sums[bin] * covered(from, to, bin);
  return sum / volume_;
}

double DomainShape::cut(const Box& box, int axis, double part) const {
  if (!(volume_ > 0)) return box.min[axis] + part * box.size()[axis];
  auto sums = profile(box, axis);
  const double from = (box.min[axis] - box_.min[axis]) / binEdge(axis);
  const double to = (box.max[axis] - box_.min[axis]) / binEdge(axis);
  double all = 0;
  for (int bin = 0; bin < kBins; ++bin) all += sums[bin] *= covered(from, to, bin);
  double left = part * all;
  for (int bin = 0; bin < kBins; ++bin) {
    if (left > sums[bin] || sums[bin] == 0) {
      left -= sums[bin];
      continue;
    }
    const double begin = std::max(from, static_cast<double>(bin));
    const double within = begin + left / sums[bin] * covered(from, to, bin);
    return box_.min[axis] + within * binEdge(axis);
  }
  return box.max[axis];
}

}  // namespace octet
