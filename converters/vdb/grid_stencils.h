// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "block_walk.h"

/// @file
/// For the sources of this folder alone. What OpenVDB's difference operators read in place of a
/// grid: a voxel and the next ones along each axis.

namespace octet {

/// A block and a layer around it, without the layer's edges, component by component.
template <typename Vector>
class PaddedBlock {
 public:
  using Real = typename Vector::value_type;
  static constexpr int kWidth = 10, kSteps[3] = {kWidth * kWidth, kWidth, 1};

  template <typename Tree>
  void fill(const BlockStar<Tree>& star) {
    for (int n = 0; n < kVoxelsOfBlock; ++n) put(place(n), star.own[n]);
    constexpr int kStepsOfLeaf[3] = {64, 8, 1};
    for (int axis = 0; axis < 3; ++axis) {
      const int across = kStepsOfLeaf[axis], outer = kStepsOfLeaf[axis == 0 ? 1 : 0],
                inner = kStepsOfLeaf[axis == 2 ? 1 : 2];
      for (int i = 0; i < 8; ++i) {
        for (int j = 0; j < 8; ++j) {
          const int first = i * outer + j * inner, last = first + 7 * across;
          put(place(first) - kSteps[axis], star.sides[axis][0][last]);
          put(place(last) + kSteps[axis], star.sides[axis][1][first]);
        }
      }
    }
  }

  /// Place of a voxel of the block.
  static int place(int n) {
    return (n / 64 + 1) * kSteps[0] + (n / 8 % 8 + 1) * kSteps[1] + n % 8 + 1;
  }

  /// What OpenVDB's operators read: a voxel and those around it.
  struct Stencil {
    using ValueType = Vector;
    const Real *x, *y, *z;
    openvdb::Coord ijk;

    template <int I, int J, int K>
    Vector getValue() const {
      constexpr int kStep = I * kSteps[0] + J * kSteps[1] + K;
      return {x[kStep], y[kStep], z[kStep]};
    }
    const openvdb::Coord& getCenterCoord() const { return ijk; }
  };
  Stencil stencil(int place, const openvdb::Coord& ijk) const {
    return {values_[0] + place, values_[1] + place, values_[2] + place, ijk};
  }

 private:
  void put(int place, const Vector& value) {
    for (int k = 0; k < 3; ++k) values_[k][place] = value[k];
  }

  Real values_[3][kWidth * kWidth * kWidth] = {};
};

/// The same for all voxels of a box that have the same things around them.
template <typename Vector>
struct BoxStencil {
  using ValueType = Vector;
  Vector own, sides[3][2];
  openvdb::Coord ijk;

  template <int I, int J, int K>
  const Vector& getValue() const {
    if constexpr (I != 0) return sides[0][I > 0];
    if constexpr (J != 0) return sides[1][J > 0];
    if constexpr (K != 0) return sides[2][K > 0];
    return own;
  }
  const openvdb::Coord& getCenterCoord() const { return ijk; }
};

}  // namespace octet
