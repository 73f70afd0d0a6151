// SPDX-License-Identifier: Apache-2.0
#include "refinement.h"

namespace octet {

Refinement::Refinement(const ControlMesh& mesh, BoundaryChoice boundary,
                       const RefinerOptions& options) {
  if (const auto method = boundaryMethod(boundary)) {
    method_ = std::make_unique<MethodRefiner>(mesh, *method, options);
  } else {
    refiner_ = std::make_unique<Refiner>(mesh, options);
    limit_ = std::make_unique<Limit>(*refiner_, options.progress);
  }
}

int Refinement::levels() const { return method_ ? method_->levels() : refiner_->levels(); }
std::shared_ptr<const Complex> Refinement::complex(int level) const {
  return method_ ? method_->sharedComplex(level) : refiner_->sharedComplex(level);
}
const Array<Vec3>& Refinement::positions(int level) const {
  return method_ ? method_->positions(level) : refiner_->positions(level);
}
const Array<Vec3>& Refinement::limitPositions() const {
  return method_ ? method_->fieldPositions() : limit_->positions();
}

bool Refinement::hasLimits() const { return !method_ || method_->hasLimits(); }
bool Refinement::commutes() const { return !method_ || method_->commutes(); }
std::string Refinement::note() const { return method_ ? methodNote(*method_) : ""; }

template <int K>
Cochain<K> Refinement::refine(const Cochain<K>& control, BoundaryMode mode) const {
  return method_ ? method_->refine(control) : refiner_->refine(control, mode);
}

Array<double> Refinement::limitValues(const Cochain<0>& control, BoundaryMode mode) const {
  return method_ ? method_->limitValues(control) : limit_->values(refiner_->refine(control, mode));
}

template <int K>
Array<Vec3> Refinement::limitVectors(const Cochain<K>& control, BoundaryMode mode) const {
  return method_ ? method_->limitVectors(control)
                 : limit_->vectors(refiner_->refine(control, mode), mode);
}

template <int K>
Field<kComponents<K>> Refinement::field(const Cochain<K>& control, BoundaryMode mode,
                                        Reconstruction reconstruction) const {
  if (method_) return method_->field(control, reconstruction);
  return makeField(*refiner_, *limit_, refiner_->refine(control, mode), mode, reconstruction);
}

template Cochain<0> Refinement::refine(const Cochain<0>&, BoundaryMode) const;
template Cochain<1> Refinement::refine(const Cochain<1>&, BoundaryMode) const;
template Cochain<2> Refinement::refine(const Cochain<2>&, BoundaryMode) const;
template Cochain<3> Refinement::refine(const Cochain<3>&, BoundaryMode) const;
template Array<Vec3> Refinement::limitVectors(const Cochain<1>&, BoundaryMode) const;
template Array<Vec3> Refinement::limitVectors(const Cochain<2>&, BoundaryMode) const;
template Field<1> Refinement::field(const Cochain<0>&, BoundaryMode, Reconstruction) const;
template Field<3> Refinement::field(const Cochain<1>&, BoundaryMode, Reconstruction) const;
template Field<3> Refinement::field(const Cochain<2>&, BoundaryMode, Reconstruction) const;
template Field<1> Refinement::field(const Cochain<3>&, BoundaryMode, Reconstruction) const;

}  // namespace octet
