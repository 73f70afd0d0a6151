// SPDX-License-Identifier: Apache-2.0
#include "thesis_subdivision.h"

#include <stdexcept>

#include "../field/limit.h"
#include "../topology/split.h"
#include "extension.h"
#include "inner_patch_test.h"
#include "layer_projection.h"
#include "real_part.h"

namespace octet {
namespace {

/// What the methods share: each has a name, and a form's boundary mode does not matter to it.
class ThesisSubdivision : public Subdivision {
 public:
  ThesisSubdivision(ThesisMethod method, double zeta) : method_(method), zeta_(zeta) {}

  int levels() const override { return static_cast<int>(complexes_.size()) - 1; }
  std::shared_ptr<const Complex> complex(int level) const override {
    return complexes_.at(static_cast<std::size_t>(level));
  }
  double zeta() const override { return zeta_; }
  std::string boundaryRule() const override { return methodName(method_); }

 protected:
  template <int K>
  const Cochain<K>& checked(const Cochain<K>& form) const {
    form.checkOn(*complexes_.front());
    return form;
  }

  const ThesisMethod method_;
  const double zeta_;
  std::vector<std::shared_ptr<const Complex>> complexes_;
};

/// Star rows at the boundary, and what Simple and Projection make of them.
class Shrinking : public ThesisSubdivision {
 public:
  Shrinking(const ControlMesh& mesh, ThesisMethod method, const RefinerOptions& options,
            const Context& context)
      : ThesisSubdivision(method, options.zeta), refiner_(mesh, shrinking(options), context) {
    for (int k = 0; k <= refiner_.levels(); ++k) complexes_.push_back(refiner_.sharedComplex(k));
    if (method != ThesisMethod::Projection || !options.smooth) return;
    positions_.push_back(refiner_.positions(0));
    for (int k = 0; k < refiner_.levels(); ++k) {
      context.poll();
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
  bool commutes() const override { return false; }
  std::string note() const override {
    return method_ == ThesisMethod::Simple
               ? "simple: coefficients on the boundary are 0, so there is divergence and curl that "
                 "the form does not have"
               : "projection: coefficients at the boundary are fitted, so there is divergence and "
                 "curl that the form does not have";
  }
  Cochain<0> refine(const Cochain<0>& control, BoundaryMode,
                    const Context& context) const override {
    return steps(checked(control), context);
  }
  Cochain<1> refine(const Cochain<1>& control, BoundaryMode,
                    const Context& context) const override {
    return steps(checked(control), context);
  }
  Cochain<2> refine(const Cochain<2>& control, BoundaryMode,
                    const Context& context) const override {
    return steps(checked(control), context);
  }
  Cochain<3> refine(const Cochain<3>& control, BoundaryMode,
                    const Context& context) const override {
    return steps(checked(control), context);
  }

  bool hasLimits() const override { return false; }
  const Array<Vec3>& limitPositions(const Context&) const override { return positions(levels()); }
  Array<double> limitValues(const Cochain<0>&, BoundaryMode, const Context&) const override {
    throw noLimits();
  }
  Array<Vec3> limitVectors(const Cochain<1>&, BoundaryMode, const Context&) const override {
    throw noLimits();
  }
  Array<Vec3> limitVectors(const Cochain<2>&, BoundaryMode, const Context&) const override {
    throw noLimits();
  }
  Array<double> limitDensities(const Cochain<3>&, BoundaryMode, const Context&) const override {
    throw noLimits();
  }

 private:
  static std::logic_error noLimits() {
    return std::logic_error("limits of a boundary method that has none");
  }
  static RefinerOptions shrinking(RefinerOptions options) {
    options.patchTest = false;
    options.boundaryRows = BoundaryRows::Star;
    return options;
  }

  template <int K>
  Cochain<K> steps(Cochain<K> form, const Context& context) const {
    for (int level = 0; level < levels(); ++level) {
      Cochain<K> fine = refiner_.step(level, form, BoundaryMode::Walls, context);
      if (method_ == ThesisMethod::Simple) {
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
class Expanding : public ThesisSubdivision {
 public:
  Expanding(const ControlMesh& mesh, const RefinerOptions& options, const Context& context)
      : ThesisSubdivision(ThesisMethod::Expansion, options.zeta),
        layer_(mesh),
        expanded_(ControlMesh::build(layer_.expanded)),
        extension_(mesh, layer_, expanded_),
        refiner_(expanded_, plain(options), context),
        limit_(refiner_, context) {
    complexes_.push_back(mesh.complex());
    RealPart control;
    control.places[0] = extension_.embedding<0>();
    control.places[1] = extension_.embedding<1>();
    control.places[2] = extension_.embedding<2>();
    control.places[3] = extension_.embedding<3>();
    parts_.push_back(std::move(control));
    for (int k = 0; k < refiner_.levels(); ++k) {
      parts_.push_back(RealPart::child(parts_.back(), *complexes_.back(), refiner_.complex(k)));
      complexes_.push_back(split(complexes_.back()));
    }
    for (int k = 0; k <= refiner_.levels(); ++k) {
      positions_.push_back(parts_[static_cast<std::size_t>(k)].ofVertices(refiner_.positions(k)));
    }
    limitPositions_ = real().ofVertices(limit_.positions());
  }

  const Array<Vec3>& positions(int level) const override {
    return positions_.at(static_cast<std::size_t>(level));
  }
  Cochain<0> refine(const Cochain<0>& control, BoundaryMode,
                    const Context& context) const override {
    return own(control, context);
  }
  Cochain<1> refine(const Cochain<1>& control, BoundaryMode,
                    const Context& context) const override {
    return own(control, context);
  }
  Cochain<2> refine(const Cochain<2>& control, BoundaryMode,
                    const Context& context) const override {
    return own(control, context);
  }
  Cochain<3> refine(const Cochain<3>& control, BoundaryMode,
                    const Context& context) const override {
    return own(control, context);
  }

  bool commutes() const override { return extension_.exact(); }
  std::string note() const override {
    if (commutes()) return "";
    return "expansion: its virtual layer fills a gap in the mesh, and around it there is "
           "divergence and curl that the form does not have";
  }

  const Array<Vec3>& limitPositions(const Context&) const override { return limitPositions_; }
  Array<double> limitValues(const Cochain<0>& control, BoundaryMode,
                            const Context& context) const override {
    return real().ofVertices(limit_.values(steps(control, context), context));
  }
  Array<Vec3> limitVectors(const Cochain<1>& control, BoundaryMode,
                           const Context& context) const override {
    return real().ofVertices(limit_.vectors(steps(control, context), BoundaryMode::Open, context));
  }
  Array<Vec3> limitVectors(const Cochain<2>& control, BoundaryMode,
                           const Context& context) const override {
    return real().ofVertices(limit_.vectors(steps(control, context), BoundaryMode::Open, context));
  }
  Array<double> limitDensities(const Cochain<3>& control, BoundaryMode,
                               const Context& context) const override {
    return real().ofVertices(limit_.densities(steps(control, context), context));
  }

 private:
  static RefinerOptions plain(RefinerOptions options) {
    options.patchTest = true;
    options.boundaryRows = BoundaryRows::Loop;
    return options;
  }
  /// What of the expanded mesh's finest level is the mesh's own.
  const RealPart& real() const { return parts_.back(); }

  template <int K>
  Cochain<K> steps(const Cochain<K>& control, const Context& context) const {
    return refiner_.refine(extension_.apply(checked(control)), BoundaryMode::Open, context);
  }
  template <int K>
  Cochain<K> own(const Cochain<K>& control, const Context& context) const {
    return real().restrict(steps(control, context));
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

}  // namespace

const char* methodName(ThesisMethod method) {
  constexpr const char* kNames[] = {"simple", "projection", "expansion"};
  return kNames[static_cast<int>(method)];
}

std::unique_ptr<Subdivision> subdivideByThesis(const ControlMesh& mesh, ThesisMethod method,
                                               const RefinerOptions& options,
                                               const Context& context) {
  if (method == ThesisMethod::Expansion) {
    return std::make_unique<Expanding>(mesh, options, context);
  }
  return std::make_unique<Shrinking>(mesh, method, options, context);
}

}  // namespace octet
