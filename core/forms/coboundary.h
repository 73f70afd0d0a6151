// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cochain.h"

namespace octet {

/// @name Exterior derivative: signed incidence (thesis 3.1.3, SCHEME.md section 2)
/// d d = 0 holds exactly in exact arithmetic and to rounding in doubles. Thread safe.
/// @throws InputError for a form that is not of the complex
/// @{
Cochain<1> d(const Complex& complex, const Cochain<0>& f);
Cochain<2> d(const Complex& complex, const Cochain<1>& w);
Cochain<3> d(const Complex& complex, const Cochain<2>& w);
/// @}

/// @name The same on bare arrays of the level's counts, for inner loops
/// @{
void coboundary0(const Complex& complex, const double* vertices, double* edges);
void coboundary1(const Complex& complex, const double* edges, double* facets);
void coboundary2(const Complex& complex, const double* facets, double* cells);
/// @}

/// Largest absolute coefficient; 0 when there is none.
double maxNorm(const Array<double>& values);

}  // namespace octet
