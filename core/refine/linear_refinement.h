// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../rules/linear_rules.h"
#include "../topology/complex.h"

namespace octet {

/// @brief The linear (Whitney) subdivision operators L0..L3 from a level to the next (SCHEME.md
/// section 4). They commute with d for every zeta. Arrays have the levels' counts. Thread safe.
class LinearRefinement {
 public:
  explicit LinearRefinement(double zeta = kDefaultZeta) : rules_(zeta) {}

  void apply0(const Complex& coarse, const double* in, double* out) const;
  void apply1(const Complex& coarse, const double* in, double* out) const;
  void apply2(const Complex& coarse, const double* in, double* out) const;
  void apply3(const Complex& coarse, const double* in, double* out) const;

 private:
  LinearRules rules_;
};

}  // namespace octet
