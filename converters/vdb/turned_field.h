// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/field/field.h>

#include "targets.h"

namespace octet {

/// From an asset's up axis to a target's.
struct AxisTurn {
  char from = 'Z', to = 'Z';

  bool changes() const { return from != to; }
  Vec3 operator()(const Vec3& v) const { return changeUpAxis(v, from, to); }
  /// Of vectors or positions.
  Array<Vec3> operator()(Array<Vec3> vectors) const;
};

/// A field whose positions, and values when they are vectors, are turned on the way.
/// @param complex  that of the field's source
template <int C>
Field<C> turnedField(const Field<C>& field, std::shared_ptr<const Complex> complex,
                     const AxisTurn& turn);

}  // namespace octet
