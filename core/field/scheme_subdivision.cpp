// SPDX-License-Identifier: Apache-2.0
#include "scheme_subdivision.h"

namespace octet {

SchemeSubdivision::SchemeSubdivision(const ControlMesh& mesh, const RefinerOptions& options,
                                     const Context& context)
    : refiner_(mesh, options, context) {}

const Limit& SchemeSubdivision::limit(const Context& context) const {
  std::call_once(once_, [&] { limit_.emplace(refiner_, context); });
  return *limit_;
}

std::shared_ptr<const Complex> SchemeSubdivision::complex(int level) const {
  return refiner_.sharedComplex(level);
}

Cochain<0> SchemeSubdivision::refine(const Cochain<0>& control, BoundaryMode mode,
                                     const Context& context) const {
  return refiner_.refine(control, mode, context);
}
Cochain<1> SchemeSubdivision::refine(const Cochain<1>& control, BoundaryMode mode,
                                     const Context& context) const {
  return refiner_.refine(control, mode, context);
}
Cochain<2> SchemeSubdivision::refine(const Cochain<2>& control, BoundaryMode mode,
                                     const Context& context) const {
  return refiner_.refine(control, mode, context);
}
Cochain<3> SchemeSubdivision::refine(const Cochain<3>& control, BoundaryMode mode,
                                     const Context& context) const {
  return refiner_.refine(control, mode, context);
}

Array<double> SchemeSubdivision::limitValues(const Cochain<0>& control, BoundaryMode mode,
                                             const Context& context) const {
  return limit(context).values(refine(control, mode, context), context);
}
Array<Vec3> SchemeSubdivision::limitVectors(const Cochain<1>& control, BoundaryMode mode,
                                            const Context& context) const {
  return limit(context).vectors(refine(control, mode, context), mode, context);
}
Array<Vec3> SchemeSubdivision::limitVectors(const Cochain<2>& control, BoundaryMode mode,
                                            const Context& context) const {
  return limit(context).vectors(refine(control, mode, context), mode, context);
}
Array<double> SchemeSubdivision::limitDensities(const Cochain<3>& control, BoundaryMode mode,
                                                const Context& context) const {
  return limit(context).densities(refine(control, mode, context), context);
}

std::unique_ptr<Subdivision> subdivideByScheme(const ControlMesh& mesh,
                                               const RefinerOptions& options,
                                               const Context& context) {
  return std::make_unique<SchemeSubdivision>(mesh, options, context);
}

}  // namespace octet
