// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field.h"

namespace octet {

/// @brief A potential f whose gradient is second-order accurate (SCHEME.md section 9): with limit
/// values f_i, limit vectors V_i and barycentric coordinates l_i, f(x) = sum l_i (f_i + V_i . (x -
/// x_i) / 2), which reproduces quadratic functions. It is the sum of two fields that are linear in
/// pieces: f(x) = base(x) + x . vectors(x) / 2.
struct GradientField {
  ScalarField base;     ///< f_i - V_i . x_i / 2
  VectorField vectors;  ///< V_i
};

/// Makes a gradient field of limit values and limit vectors at the vertices of a complex.
GradientField makeGradientField(const std::shared_ptr<const Complex>& complex,
                                const Array<Vec3>& positions, const Array<double>& values,
                                Array<Vec3> vectors);

}  // namespace octet
