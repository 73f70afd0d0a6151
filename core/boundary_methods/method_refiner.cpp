// SPDX-License-Identifier: Apache-2.0
#include "method_refiner.h"

#include <stdexcept>

#include "../field/vertex_field.h"
#include "../field/whitney.h"
#include "../topology/split.h"
#include "extension.h"
#include "inner_patch_test.h"
#include "layer_projection.h"
#include "real_part.h"

namespace octet {

/// What the methods differ in.
class MethodRefiner::Rules {
 public:
  virtual ~Rules() = default;
  virtual const Array<Vec3>& positions(int level) const = 0;
  virtual Cochain<0> refine(const Cochain<0>& form, int level) const = 0;
  virtual Cochain<1> refine(const Cochain<1>& form, int level) const = 0;
  virtual Cochain<2> refine(const Cochain<2>& form, int level) const = 0;
  virtual Cochain<3> refine(const Cochain<3>& form, int level) const = 0;
  virtual bool commutes() const { return false; }
  virtual const Array<Vec3>& fieldPositions() const { return positions(levels()); }
  /// Limit vectors or values at the finest vertices, where the method has them.
  virtual bool hasLimits() const { return false; }
  virtual Array<double> values(const Cochain<0>&) const { throw noLimits(); }
  virtual Array<Vec3> vectors(const Cochain<1>&) const { throw noLimits(); }
  virtual Array<Vec3> vectors(const Cochain<2>&) const { throw noLimits(); }
  virtual Array<double> values(const Cochain<3>&) const { throw noLimits(); }

  int levels() const { return static_cast<int>(complexes.size()) - 1; }

  BoundaryMethod method = BoundaryMethod::Simple;
  double zeta = kDefaultZeta;
  std::vector<std::shared_ptr<const Complex>> complexes;

 private:
  static std::logic_error noLimits() {
    return std::logic_error("limits of a boundary method that has none");
  }
};

/// Star rows at the boundary, and what Simple and Projection make of them.
class MethodRefiner::ShrinkingRules : public Rules {
 public:
  ShrinkingRules(const ControlMesh& mesh, BoundaryMethod which, RefinerOptions options)
      : refiner_(mesh, shrinking(options)) {
    method = which;
    zeta = options.zeta;
    for (int k = 0; k <= refiner_.levels(); ++k) complexes.push_back(refiner_.sharedComplex(k));
    if (which != BoundaryMethod::Projection || !options.smooth) return;
    positions_.push_back(refiner_.positions(0));
    for (int k = 0; k < refiner_.levels(); ++k) {
      layers_.push_back(std::make_unique<LayerProjection>(refiner_, k, positions_.back()));
      positions_.push_back(layers_.back()->finePositions());
      patchTests_.emplace_back(refiner_, k, positions_[static_cast<std::size_t>(k)],
                               positions_.back());
    }
  }

  const Array<Vec3>& positions(int level) const override {
    return layers_.empty() ? refiner_.positions(level)
                           : positions_.at(static_cast<std::size_t>(level));
  }
  Cochain<0> refine(const Cochain<0>& form, int level) const override { return steps(form, level); }
  Cochain<1> refine(const Cochain<1>& form, int level) const override { return steps(form, level); }
  Cochain<2> refine(const Cochain<2>& form, int level) const override { return steps(form, level); }
  Cochain<3> refine(const Cochain<3>& form, int level) const override { return steps(form, level); }

 private:
  static RefinerOptions shrinking(RefinerOptions options) {
    options.patchTest = false;
    options.boundaryRows = BoundaryRows::Star;
    return options;
  }

  template <int K>
  Cochain<K> steps(Cochain<K> form, int levels) const {
    for (int level = 0; level < levels; ++level) {
      Cochain<K> fine = refiner_.step(level, form, BoundaryMode::Walls);
      if (method == BoundaryMethod::Simple) {
        clearBoundary(level + 1, &fine);
      } else if (!layers_.empty()) {
        const auto step = static_cast<std::size_t>(level);
        const LayerProjection& layer = *layers_[step];
        if constexpr (K == 2) patchTests_[step].correct(form, &fine);
        if constexpr (K == 0) layer.correct(form, &fine);
        if constexpr (K == 1 || K == 2) layer.replace(form, &fine);
      }
      form = std::move(fine);
    }
    return form;
  }

  template <int K>
  void clearBoundary(int level, Cochain<K>* form) const {
    if constexpr (K == 1) {
      for (const Index e : refiner_.boundary(level).edges) (*form)[e] = 0;
    }
    if constexpr (K == 2) {
      for (const Index f : refiner_.boundary(level).facets) (*form)[f] = 0;
    }
  }

  Refiner refiner_;
  std::vector<std::unique_ptr<LayerProjection>> layers_;
  std::vector<InnerPatchTest> patchTests_;
  std::vector<Array<Vec3>> positions_;
};

/// The scheme on the expanded mesh; the virtual layer is never looked at beyond what its first
/// level of cells needs, so it is not trimmed but left unread.
class MethodRefiner::ExpandingRules : public Rules {
 public:
  ExpandingRules(const ControlMesh& mesh, const RefinerOptions& options)
      : layer_(mesh),
        expanded_(ControlMesh::build(layer_.expanded)),
        extension_(mesh, layer_, expanded_),
        refiner_(expanded_, plain(options)),
        limit_(refiner_) {
    method = BoundaryMethod::Expansion;
    zeta = options.zeta;
    complexes.push_back(mesh.complex());
    RealPart control;
    control.places[0] = extension_.embedding<0>();
    control.places[1] = extension_.embedding<1>();
    control.places[2] = extension_.embedding<2>();
    control.places[3] = extension_.embedding<3>();
    parts_.push_back(std::move(control));
    for (int k = 0; k < refiner_.levels(); ++k) {
      parts_.push_back(RealPart::child(parts_.back(), *complexes.back(), refiner_.complex(k)));
      complexes.push_back(split(complexes.back()));
    }
    for (int k = 0; k <= refiner_.levels(); ++k) {
      positions_.push_back(part(k).ofVertices(refiner_.positions(k)));
    }
    limitPositions_ = part(levels()).ofVertices(limit_.positions());
  }

  const Array<Vec3>& positions(int level) const override {
    return positions_.at(static_cast<std::size_t>(level));
  }
  Cochain<0> refine(const Cochain<0>& form, int level) const override { return own(form, level); }
  Cochain<1> refine(const Cochain<1>& form, int level) const override { return own(form, level); }
  Cochain<2> refine(const Cochain<2>& form, int level) const override { return own(form, level); }
  Cochain<3> refine(const Cochain<3>& form, int level) const override { return own(form, level); }

  bool commutes() const override { return extension_.exact(); }
  const Array<Vec3>& fieldPositions() const override { return limitPositions_; }
  bool hasLimits() const override { return true; }
  Array<double> values(const Cochain<0>& form) const override {
    return part(levels()).ofVertices(limit_.values(steps(form, levels())));
  }
  Array<Vec3> vectors(const Cochain<1>& form) const override {
    return part(levels()).ofVertices(limit_.vectors(steps(form, levels()), BoundaryMode::Open));
  }
  Array<Vec3> vectors(const Cochain<2>& form) const override {
    return part(levels()).ofVertices(limit_.vectors(steps(form, levels()), BoundaryMode::Open));
  }
  Array<double> values(const Cochain<3>& form) const override {
    return part(levels()).ofVertices(limit_.densities(steps(form, levels())));
  }

 private:
  static RefinerOptions plain(RefinerOptions options) {
    options.patchTest = true;
    options.boundaryRows = BoundaryRows::Surface;
    return options;
  }
  const RealPart& part(int level) const { return parts_[static_cast<std::size_t>(level)]; }

  template <int K>
  Cochain<K> steps(const Cochain<K>& form, int levels) const {
    Cochain<K> result = extension_.apply(form);
    for (int k = 0; k < levels; ++k) result = refiner_.step(k, result, BoundaryMode::Open);
    return result;
  }
  template <int K>
  Cochain<K> own(const Cochain<K>& form, int levels) const {
    return part(levels).restrict(steps(form, levels));
  }

  VirtualLayer layer_;
  ControlMesh expanded_;
  Extension extension_;
  Refiner refiner_;
  Limit limit_;
  std::vector<RealPart> parts_;
  std::vector<Array<Vec3>> positions_;
  Array<Vec3> limitPositions_;
};

MethodRefiner::MethodRefiner(const ControlMesh& mesh, BoundaryMethod method,
                             const RefinerOptions& options) {
  if (method == BoundaryMethod::Expansion) {
    rules_ = std::make_unique<ExpandingRules>(mesh, options);
  } else {
    rules_ = std::make_unique<ShrinkingRules>(mesh, method, options);
  }
}

MethodRefiner::~MethodRefiner() = default;
MethodRefiner::MethodRefiner(MethodRefiner&&) noexcept = default;
MethodRefiner& MethodRefiner::operator=(MethodRefiner&&) noexcept = default;

int MethodRefiner::levels() const { return rules_->levels(); }
BoundaryMethod MethodRefiner::method() const { return rules_->method; }
bool MethodRefiner::commutes() const { return rules_->commutes(); }
bool MethodRefiner::hasLimits() const { return rules_->hasLimits(); }
const Complex& MethodRefiner::complex(int level) const { return *sharedComplex(level); }
std::shared_ptr<const Complex> MethodRefiner::sharedComplex(int level) const {
  return rules_->complexes.at(static_cast<std::size_t>(level));
}
const Array<Vec3>& MethodRefiner::positions(int level) const { return rules_->positions(level); }
const Array<Vec3>& MethodRefiner::fieldPositions() const { return rules_->fieldPositions(); }

template <int K>
Cochain<K> MethodRefiner::refine(const Cochain<K>& form, int level) const {
  if (form.size() != complex(0).count(K)) {
    throw InputError("", "a form of degree " + std::to_string(K) + " has " +
                             std::to_string(complex(0).count(K)) + " coefficients, not " +
                             std::to_string(form.size()));
  }
  return rules_->refine(form, level);
}

Array<double> MethodRefiner::limitValues(const Cochain<0>& form) const {
  return rules_->values(form);
}

template <int K>
Array<Vec3> MethodRefiner::limitVectors(const Cochain<K>& form) const {
  return rules_->vectors(form);
}

template <int K>
Field<kComponents<K>> MethodRefiner::field(const Cochain<K>& form,
                                           Reconstruction reconstruction) const {
  constexpr int C = kComponents<K>;
  const auto finest = sharedComplex(levels());
  if (reconstruction == Reconstruction::Whitney || !rules_->hasLimits()) {
    return Field<C>(
        std::make_shared<Whitney<K>>(finest, positions(levels()), refine(form), rules_->zeta));
  }
  Array<typename Piece<C>::Value> values;
  if constexpr (C == 3) {
    values = rules_->vectors(form);
  } else {
    for (const double x : rules_->values(form)) values.push_back(typename Piece<C>::Value(x));
  }
  return Field<C>(std::make_shared<VertexField<C>>(finest, fieldPositions(), std::move(values)));
}

template Cochain<0> MethodRefiner::refine(const Cochain<0>&, int) const;
template Cochain<1> MethodRefiner::refine(const Cochain<1>&, int) const;
template Cochain<2> MethodRefiner::refine(const Cochain<2>&, int) const;
template Cochain<3> MethodRefiner::refine(const Cochain<3>&, int) const;
template Array<Vec3> MethodRefiner::limitVectors(const Cochain<1>&) const;
template Array<Vec3> MethodRefiner::limitVectors(const Cochain<2>&) const;
template Field<1> MethodRefiner::field(const Cochain<0>&, Reconstruction) const;
template Field<3> MethodRefiner::field(const Cochain<1>&, Reconstruction) const;
template Field<3> MethodRefiner::field(const Cochain<2>&, Reconstruction) const;
template Field<1> MethodRefiner::field(const Cochain<3>&, Reconstruction) const;

}  // namespace octet
