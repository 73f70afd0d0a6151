// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field.h"

namespace octet {

/// Turns vectors and positions from one up axis, 'Y' or 'Z', to another: 'Z' to 'Y' is
/// (x, y, z) -> (x, z, -y).
struct AxisTurn {
  char from = 'Z', to = 'Z';

  bool changes() const { return from != to; }
  Vec3 operator()(const Vec3& v) const;
  /// Turns many.
  Array<Vec3> operator()(Array<Vec3> vectors) const;
};

/// Makes a field whose positions, and values when they are vectors, are turned on the way.
/// @param complex  that of the field's source
template <int C>
Field<C> turnedField(const Field<C>& field, std::shared_ptr<const Complex> complex,
                     const AxisTurn& turn);

}  // namespace octet
