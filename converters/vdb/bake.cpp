// SPDX-License-Identifier: Apache-2.0
#include "bake.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <unistd.h>

#include <octet/core/base/parallel.h>
#include <octet/core/field/vertex_field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/geometry/domain_box.h>

#include "velocity_plan.h"

namespace octet {
namespace {

/// Automatic levels refine until the mean fine edge is at most this many voxels.
constexpr double kVoxelsPerEdge = 2;
/// What a cell of the finest level takes in memory, at most (tests/bench/memory.cpp).
constexpr double kBytesPerCell = 600;

/// Sums of coefficients this small, relative to the largest, are rounding.
constexpr double kCancelled = 1e-14;

double meanEdge(const Complex& complex, const Array<Vec3>& positions) {
  double sum = 0;
  for (const auto& [a, b] : complex.edges) sum += (positions[b] - positions[a]).norm();
  return complex.edges.empty() ? 0 : sum / static_cast<double>(complex.edges.size());
}

/// The machine's memory in bytes. Beyond it the system would end the program, or others.
double machineMemory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? static_cast<double>(pages) * static_cast<double>(size) : HUGE_VAL;
}

/// Positions and values of pieces turned on the way.
template <int C>
class TurnedSource : public PieceSource<C> {
 public:
  TurnedSource(const Field<C>& field, std::shared_ptr<const Complex> complex, char from, char to)
      : PieceSource<C>(std::move(complex), turnAll(field.source().positions(), from, to)),
        field_(field),
        from_(from),
        to_(to) {}

  void visitPieces(Index cell, const typename PieceSource<C>::Filter& wanted,
                   const typename PieceSource<C>::Sink& sink) const override {
    const auto boxWanted = [&](const Box& box) {
      Box turnedBox;
      turnedBox.extend(changeUpAxis(box.min, from_, to_));
      turnedBox.extend(changeUpAxis(box.max, from_, to_));
      return wanted(turnedBox);
    };
    field_.source().visitPieces(cell, boxWanted, [&](const Piece<C>& piece) {
      Piece<C> result = piece;
      for (int i = 0; i < 4; ++i) {
        result.points[i] = changeUpAxis(piece.points[i], from_, to_);
        if constexpr (C == 3) result.values[i] = changeUpAxis(piece.values[i], from_, to_);
      }
      sink(result);
    });
  }

 private:
  static Array<Vec3> turnAll(const Array<Vec3>& positions, char from, char to) {
    Array<Vec3> result(positions.size());
    parallelFor<std::size_t>(
        positions.size(), [&](std::size_t k) { result[k] = changeUpAxis(positions[k], from, to); });
    return result;
  }

  Field<C> field_;
  char from_, to_;
};

class Baker {
 public:
  Baker(const ControlAsset& asset, const BakeOptions& options)
      : asset_(asset),
        options_(options),
        target_(findTarget(options.target)),
        planner_(asset.mesh) {
    selectForms();
    chooseGrid();
  }

  BakeReport run(const std::string& path) {
    RefinerOptions refinerOptions;
    refinerOptions.levels = report_.levels;
    refinerOptions.zeta = options_.zeta;
    refinerOptions.progress = options_.progress;
    if (const auto method = boundaryMethod(options_.boundary)) {
      method_ = std::make_unique<MethodRefiner>(asset_.mesh, *method, refinerOptions);
      finest_ = method_->sharedComplex(method_->levels());
    } else {
      refiner_ = std::make_unique<Refiner>(asset_.mesh, refinerOptions);
      limit_ = std::make_unique<Limit>(*refiner_, options_.progress);
      finest_ = refiner_->sharedComplex(refiner_->levels());
    }
    report_.cells = finest_->cellCount();
    report_.meanEdge =
        meanEdge(*finest_, method_ ? method_->fieldPositions() : limit_->positions());
    report_.note = target_.note;

    const auto frames = frameRange();
    if (!frames) {
      report_.files.push_back(bakeFile(path, std::nullopt));
      return report_;
    }
    for (int frame = frames->first; frame <= frames->second; ++frame) {
      report_.files.push_back(bakeFile(numbered(path, frame), frame));
    }
    return report_;
  }

 private:
  /// Degree of what is baked of a form.
  int degreeOf(const Form& form) const { return form.degree + (options_.derivative ? 1 : 0); }

  void selectForms() {
    if (options_.forms.empty()) {
      for (const Form& form : asset_.forms) {
        if (!options_.derivative || form.degree < 3) forms_.push_back(&form);
      }
      if (forms_.empty()) {
        throw InputError("", options_.derivative ? "the asset has no form with a derivative"
                                                 : "the asset has no forms to bake");
      }
    }
    for (const std::string& name : options_.forms) {
      const Form& form = asset_.form(name);
      if (options_.derivative && form.degree == 3) {
        throw InputError("", "form \"" + name + "\" has degree 3 and no derivative");
      }
      if (std::find(forms_.begin(), forms_.end(), &form) == forms_.end()) forms_.push_back(&form);
    }
    // The velocity, which a target looks for by name: the first flux form, else the first vector.
    for (const int degree : {2, 1}) {
      for (const Form* form : forms_) {
        if (!velocity_ && degreeOf(*form) == degree) velocity_ = form;
      }
    }
    for (const Form* form : forms_) {
      for (const Form* other : forms_) {
        if (form != other && gridName(*form) == gridName(*other)) {
          throw InputError("", "forms \"" + form->name + "\" and \"" + other->name +
                                   "\" would both become grid \"" + gridName(*form) +
                                   "\" for target " + target_.name + "; choose with --form");
        }
      }
    }
  }

  std::string gridName(const Form& form) const {
    return &form == velocity_ && target_.velocityName[0] ? target_.velocityName : form.name;
  }

  void chooseGrid() {
    const bool bySize = options_.voxelSize != 0, byCount = options_.resolution != 0;
    if (bySize == byCount) {
      throw InputError("voxel size", bySize ? "is given twice, also as a resolution"
                                            : "is missing: give it or a resolution");
    }
    // The domain, as its limit surface shows it after one level.
    RefinerOptions coarse;
    coarse.levels = 1;
    coarse.zeta = options_.zeta;
    const Refiner refiner(asset_.mesh, coarse);
    const Limit limit(refiner);
    const Box box = domainBox(refiner.finest(), limit.positions());
    if (bySize) {
      if (!(options_.voxelSize > 0) || !std::isfinite(options_.voxelSize)) {
        throw InputError("voxel size", "is not a positive number");
      }
      report_.voxelSize = options_.voxelSize;
    } else {
      if (options_.resolution < 1) throw InputError("resolution", "is less than 1");
      report_.voxelSize = box.size().maxCoeff() / options_.resolution;
    }
    // A level halves edges and makes eight times the cells, about.
    const double cellsAtOne = static_cast<double>(refiner.finest().cellCount());
    const auto cellsAt = [&](int levels) { return cellsAtOne * std::pow(8.0, levels - 1); };
    if (options_.levels) {
      report_.levels = *options_.levels;
    } else {
      double edge = meanEdge(*asset_.mesh.complex(), asset_.mesh.positions());
      while (edge > kVoxelsPerEdge * report_.voxelSize) {
        edge = report_.levels == 0 ? meanEdge(refiner.finest(), limit.positions()) : edge / 2;
        ++report_.levels;
      }
    }
    const double needed = kBytesPerCell * cellsAt(report_.levels), there = machineMemory();
    if (needed > there) {
      const auto inUnits = [](double x, double unit) {
        return std::to_string(static_cast<std::int64_t>(std::llround(x / unit)));
      };
      throw InputError("levels", std::to_string(report_.levels) + " would make about " +
                                     inUnits(cellsAt(report_.levels), 1e6) +
                                     " million cells, which need up to " + inUnits(needed, 1e9) +
                                     " GB of memory; this machine has " + inUnits(there, 1e9) +
                                     " GB; give fewer --levels or larger voxels");
    }
    frame_.voxelSize = report_.voxelSize;
  }

  std::optional<std::pair<int, int>> frameRange() const {
    std::optional<std::pair<int, int>> range;
    for (const Form* form : forms_) {
      if (!form->animated()) continue;
      const int first = form->frames.begin()->first, last = form->frames.rbegin()->first;
      range = range ? std::pair{std::min(range->first, first), std::max(range->second, last)}
                    : std::pair{first, last};
    }
    if (!options_.frames) return range;
    if (options_.frames->first > options_.frames->second) {
      throw InputError("frames", "the first is after the last");
    }
    if (!range) throw InputError("frames", "the asset's forms are not animated");
    if (options_.frames->first < range->first || options_.frames->second > range->second) {
      throw InputError("frames", "the asset has frames " + std::to_string(range->first) + "-" +
                                     std::to_string(range->second));
    }
    return options_.frames;
  }

  /// name.vdb, 7 -> name.0007.vdb
  static std::string numbered(const std::string& path, int frame) {
    char number[16];
    std::snprintf(number, sizeof number, ".%04d", frame);
    const std::filesystem::path p(path);
    return (p.parent_path() / (p.stem().string() + number + p.extension().string())).string();
  }

  BakedFile bakeFile(const std::string& path, std::optional<int> frame) {
    BakedFile file{path, frame, {}};
    VdbFile vdb;
    for (const Form* form : forms_) {
      const auto with = [&](auto degree) {
        constexpr int K = decltype(degree)::value;
        return options_.derivative ? bakeDerivative<K>(*form, frame, &vdb)
                                   : bakeForm<K>(*form, frame, &vdb);
      };
      switch (form->degree) {
        case 0:
          file.grids.push_back(with(std::integral_constant<int, 0>{}));
          break;
        case 1:
          file.grids.push_back(with(std::integral_constant<int, 1>{}));
          break;
        case 2:
          file.grids.push_back(with(std::integral_constant<int, 2>{}));
          break;
        default:
          file.grids.push_back(bakeForm<3>(*form, frame, &vdb));
      }
    }
    std::vector<VdbMetadata> metadata = {{"octet_asset", asset_.name},
                                         {"octet_up_axis", std::string(1, upAxis())},
                                         {"octet_meters_per_unit", asset_.units.metersPerUnit},
                                         {"octet_frames_per_second", asset_.units.framesPerSecond}};
    if (frame) metadata.push_back({"octet_frame", static_cast<std::int32_t>(*frame)});
    vdb.write(path, metadata, options_.progress);
    return file;
  }

  /// Of the thesis' methods only expansion has limits.
  bool limitFields() const {
    return options_.reconstruction == Reconstruction::Limit &&
           (!method_ || method_->method() == BoundaryMethod::Expansion);
  }

  char upAxis() const { return target_.upAxis ? target_.upAxis : asset_.units.upAxis; }

  template <int K>
  VdbGridInfo bakeForm(const Form& form, std::optional<int> frame, VdbFile* vdb) const {
    const BoundaryMode mode = boundaryMode(asset_, form, options_.boundary);
    Cochain<K> control = coefficients<K>(asset_, form, frame.value_or(0));
    std::string note;
    if constexpr (K == 1 || K == 2) {
      if (options_.project) {
        auto closed = planner_.closest(control);
        control = std::move(closed.form);
        note = std::move(closed.note);
      }
    }
    if (method_) {
      return addField<K>(form, method_->field(control, options_.reconstruction), mode, note, vdb);
    }
    if constexpr (K == 1) return addGradient(form, control, nullptr, mode, note, vdb);
    if constexpr (K == 2) return addFlux(form, control, nullptr, mode, note, vdb);
    return add<K>(form, refiner_->refine(std::move(control), mode), mode, note, vdb);
  }

  /// d commutes with refinement: refining the derivative is differentiating the refined form.
  template <int K>
  VdbGridInfo bakeDerivative(const Form& form, std::optional<int> frame, VdbFile* vdb) const {
    BoundaryMode mode =
        options_.boundary == BoundaryChoice::Open ? BoundaryMode::Open : BoundaryMode::Walls;
    if (options_.boundary == BoundaryChoice::Auto) {
      // One mode for all frames, as the derivative's own boundary says.
      std::vector<int> frames = {0};
      if (form.animated()) frames.clear();
      for (const auto& [number, values] : form.frames) frames.push_back(number);
      for (const int number : frames) {
        if (automaticMode(*asset_.mesh.complex(), derivative<K>(form, number)) ==
            BoundaryMode::Open) {
          mode = BoundaryMode::Open;
        }
      }
    }
    Cochain<K + 1> control = derivative<K>(form, frame.value_or(0));
    if (method_) {
      return addField<K + 1>(form, method_->field(control, options_.reconstruction), mode, "", vdb);
    }
    if constexpr (K == 0) {
      const auto potential = coefficients<0>(asset_, form, frame.value_or(0));
      return addGradient(form, control, &potential, mode, "", vdb);
    }
    if constexpr (K == 1) {
      const auto potential = coefficients<1>(asset_, form, frame.value_or(0));
      return addFlux(form, control, &potential, mode, "", vdb);
    }
    return add<K + 1>(form, refiner_->refine(std::move(control), mode), mode, "", vdb);
  }

  /// The derivative on the control mesh; coefficients that cancel up to rounding are 0.
  template <int K>
  Cochain<K + 1> derivative(const Form& form, int frame) const {
    Cochain<K + 1> result = d(*asset_.mesh.complex(), coefficients<K>(asset_, form, frame));
    const double scale = maxNorm(result.values());
    for (double& x : result.values()) {
      if (std::abs(x) < kCancelled * scale) x = 0;
    }
    return result;
  }

  /// A staggered flux is baked from its vector potential, when it has one: by commutation the
  /// refined potential's derivative is the refined form.
  VdbGridInfo addFlux(const Form& form, const Cochain<2>& control, const Cochain<1>* given,
                      BoundaryMode mode, std::string note, VdbFile* vdb) const {
    const auto say = [&note](const std::string& more) {
      if (!more.empty()) note += (note.empty() ? "" : "; ") + more;
    };
    Cochain<2> finest = refiner_->refine(control, mode);
    if (options_.sampling == Sampling::Collocated) {
      say(planner_.describeOpenness(control));
      return add<2>(form, std::move(finest), mode, note, vdb);
    }
    if (options_.reconstruction == Reconstruction::Limit && !options_.samplesOnly) {
      const VelocityPlan plan = planner_.plan(control, given);
      say(plan.note);
      if (plan.potential) {
        const PotentialField field = potentialField(*plan.potential, finest, mode);
        VdbGridSpec spec = gridSpec<2>(form, mode);
        spec.method = "circulations";
        spec.note = note;
        return vdb->add(field, spec, options_.progress);
      }
    }
    return add<2>(form, std::move(finest), mode, note, vdb);
  }

  /// A gradient is baked as differences of its potential, when it has one.
  VdbGridInfo addGradient(const Form& form, const Cochain<1>& control, const Cochain<0>* given,
                          BoundaryMode mode, std::string note, VdbFile* vdb) const {
    Cochain<1> finest = refiner_->refine(control, mode);
    std::optional<Cochain<0>> potential;
    if (options_.reconstruction == Reconstruction::Limit && !options_.samplesOnly) {
      potential = given ? *given : scalarPotential(*asset_.mesh.complex(), control);
    }
    if (!potential) {
      const std::string open = planner_.describeOpenness(control);
      if (!open.empty()) note += (note.empty() ? "" : "; ") + open;
      return add<1>(form, std::move(finest), mode, note, vdb);
    }
    VdbGridSpec spec = gridSpec<1>(form, mode);
    spec.method = "differences";
    spec.note = note;
    return vdb->add(gradientField(*potential, finest, mode), spec, options_.progress);
  }

  GradientField gradientField(const Cochain<0>& potential, const Cochain<1>& finest,
                              BoundaryMode mode) const {
    const auto complex = refiner_->sharedComplex(refiner_->levels());
    const Array<double> values = limit_->values(refiner_->refine(potential, mode));
    Array<Vec3> vectors = limit_->vectors(finest, mode);
    Array<Piece<1>::Value> base(values.size());
    parallelFor<std::size_t>(values.size(), [&](std::size_t k) {
      base[k][0] = values[k] - vectors[k].dot(limit_->positions()[k]) / 2;
    });
    return {turned(ScalarField(
                std::make_shared<VertexField<1>>(complex, limit_->positions(), std::move(base)))),
            turned(VectorField(std::make_shared<VertexField<3>>(complex, limit_->positions(),
                                                                std::move(vectors))))};
  }

  /// The field with the target's axes.
  template <int C>
  Field<C> turned(Field<C> field) const {
    if (upAxis() == asset_.units.upAxis) return field;
    return Field<C>(
        std::make_shared<TurnedSource<C>>(field, finest_, asset_.units.upAxis, upAxis()));
  }

  PotentialField potentialField(const VectorPotential& potential, const Cochain<2>& finest,
                                BoundaryMode mode) const {
    const int level = refiner_->levels();
    const auto turnedAll = [&](Array<Vec3> vectors) {
      parallelFor<std::size_t>(vectors.size(), [&](std::size_t k) {
        vectors[k] = changeUpAxis(vectors[k], asset_.units.upAxis, upAxis());
      });
      return vectors;
    };
    return PotentialField(refiner_->sharedComplex(level), turnedAll(refiner_->positions(level)),
                          refiner_->refine(potential.form, mode),
                          turnedAll(limit_->vectors(finest, mode)), mode == BoundaryMode::Walls);
  }

  template <int K>
  VdbGridInfo add(const Form& form, Cochain<K> finest, BoundaryMode mode, const std::string& note,
                  VdbFile* vdb) const {
    return addField<K>(
        form, makeField(*refiner_, *limit_, std::move(finest), mode, options_.reconstruction), mode,
        note, vdb);
  }

  template <int K>
  VdbGridInfo addField(const Form& form, Field<kComponents<K>> field, BoundaryMode mode,
                       const std::string& note, VdbFile* vdb) const {
    field = turned(std::move(field));
    VdbGridSpec spec = gridSpec<K>(form, mode);
    spec.note = note;
    return vdb->add(field, spec, options_.progress);
  }

  template <int K>
  VdbGridSpec gridSpec(const Form& form, BoundaryMode mode) const {
    VdbGridSpec spec;
    spec.name = gridName(form);
    spec.frame = frame_;
    spec.half = options_.half;
    if (target_.voxelCornered) spec.shift = Vec3::Constant(-frame_.voxelSize / 2);
    if constexpr (K == 1 || K == 2) {
      spec.sampling = options_.sampling;
      spec.vectorType = K == 1 ? VdbGridSpec::VectorType::Covariant
                               : VdbGridSpec::VectorType::ContravariantRelative;
      spec.gridClass = target_.fogClass                       ? VdbGridSpec::Class::Fog
                       : spec.sampling == Sampling::Staggered ? VdbGridSpec::Class::Staggered
                                                              : VdbGridSpec::Class::Unknown;
    } else {
      spec.gridClass =
          K == 3 || target_.fogClass ? VdbGridSpec::Class::Fog : VdbGridSpec::Class::Unknown;
    }
    spec.metadata = {{"octet_form", form.name},
                     {"octet_degree", static_cast<std::int32_t>(K)},
                     {"octet_derivative", static_cast<std::int32_t>(options_.derivative)},
                     {"octet_unit", form.unit},
                     {"octet_levels", static_cast<std::int32_t>(report_.levels)},
                     {"octet_boundary", std::string(method_ ? boundaryName(options_.boundary)
                                                    : mode == BoundaryMode::Walls ? "walls"
                                                                                  : "open")},
                     {"octet_reconstruction", std::string(limitFields() ? "limit" : "whitney")}};
    return spec;
  }

  const ControlAsset& asset_;
  const BakeOptions& options_;
  const Target& target_;
  VelocityPlanner planner_;
  std::vector<const Form*> forms_;
  const Form* velocity_ = nullptr;
  GridFrame frame_;
  BakeReport report_;
  std::unique_ptr<Refiner> refiner_;
  std::unique_ptr<Limit> limit_;
  std::unique_ptr<MethodRefiner> method_;  // in their place, for a method of the thesis
  std::shared_ptr<const Complex> finest_;
};

}  // namespace

BakeReport bake(const ControlAsset& asset, const BakeOptions& options, const std::string& path) {
  return Baker(asset, options).run(path);
}

}  // namespace octet
