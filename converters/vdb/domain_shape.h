// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <octet/core/field/turned_field.h>
#include <octet/core/geometry/box_bins.h>

namespace octet {

/// The box around a turned box.
Box turnedBox(const Box& box, const AxisTurn& turn);

/// @brief How a mesh fills space, roughly: to foresee how many voxels lie in it, and to cut it into
/// parts of equal volume. The same mesh gives the same numbers, at any number of threads.
class DomainShape {
 public:
  DomainShape() = default;
  /// @param turn  from the axes of the positions to those of the shape
  DomainShape(const Complex& complex, const Array<Vec3>& positions, const AxisTurn& turn);

  const Box& box() const { return box_; }
  double volume() const { return volume_; }

  /// Foresees at how many points of a cubic lattice a cube meets the mesh: exact in the mean over
  /// places of the lattice when the mesh is convex (Steiner's formula), else too many.
  double cubes(double spacing, double edge) const;

  /// Share of the volume that lies in a box.
  double share(const Box& box) const;
  /// Where a plane across an axis has this part of the volume in a box below it.
  double cut(const Box& box, int axis, double part) const;

 private:
  /// Volume is kept in so many bins along each axis of the box.
  static constexpr int kBins = 32;

  void addCell(const Box& cell, double volume);
  std::array<double, kBins> profile(const Box& box, int axis) const;
  double binEdge(int axis) const { return box_.size()[axis] / kBins; }

  Box box_;
  double volume_ = 0;
  Vec3 shadow_ = Vec3::Zero();  // area seen along each axis, from both sides, halved
  std::vector<double> bins_;
};

}  // namespace octet
