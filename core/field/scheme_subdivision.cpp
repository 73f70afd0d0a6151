// SPDX-License-Identifier: Apache-2.0
#include "scheme_subdivision.h"

namespace octet {

SchemeSubdivision::SchemeSubdivision(const ControlMesh& mesh, const RefinerOptions& options)
    : refiner_(mesh, options), progress_(options.progress) {}

const Limit& SchemeSubdivision::limit() const {
  std::call_once(once_, [&] { limit_.emplace(refiner_, progress_); });
  return *limit_;
}

std::shared_ptr<const Complex> SchemeSubdivision::complex(int level) const {
  return refiner_.sharedComplex(level);
}

Cochain<0> SchemeSubdivision::refine(const Cochain<0>& control, BoundaryMode mode) const {
  return refiner_.refine(control, mode);
}
Cochain<1> SchemeSubdivision::refine(const Cochain<1>& control, BoundaryMode mode) const {
  return refiner_.refine(control, mode);
}
Cochain<2> SchemeSubdivision::refine(const Cochain<2>& control, BoundaryMode mode) const {
  return refiner_.refine(control, mode);
}
Cochain<3> SchemeSubdivision::refine(const Cochain<3>& control, BoundaryMode mode) const {
  return refiner_.refine(control, mode);
}

Array<double> SchemeSubdivision::limitValues(const Cochain<0>& control, BoundaryMode mode) const {
  return limit().values(refine(control, mode));
}
Array<Vec3> SchemeSubdivision::limitVectors(const Cochain<1>& control, BoundaryMode mode) const {
  return limit().vectors(refine(control, mode), mode);
}
Array<Vec3> SchemeSubdivision::limitVectors(const Cochain<2>& control, BoundaryMode mode) const {
  return limit().vectors(refine(control, mode), mode);
}
Array<double> SchemeSubdivision::limitDensities(const Cochain<3>& control,
                                                BoundaryMode mode) const {
  return limit().densities(refine(control, mode));
}

std::unique_ptr<Subdivision> subdivideByScheme(const ControlMesh& mesh,
                                               const RefinerOptions& options) {
  return std::make_unique<SchemeSubdivision>(mesh, options);
}

}  // namespace octet
