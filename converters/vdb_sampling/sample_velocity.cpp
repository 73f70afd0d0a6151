// SPDX-License-Identifier: Apache-2.0
#include "sample_velocity.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include <octet/core/base/reported_loop.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/composite_de_rham.h>

#include "../control_asset/refined_document.h"
#include "../io/frames.h"

namespace octet {
namespace {

/// The number that the last digits of a file's name make; none when there are none.
std::optional<int> frameNumber(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem().string();
  std::size_t end = stem.size();
  while (end > 0 && !std::isdigit(static_cast<unsigned char>(stem[end - 1]))) --end;
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1]))) --begin;
  constexpr std::size_t kMostDigits = 9;
  if (begin == end || end - begin > kMostDigits) return std::nullopt;
  return std::stoi(stem.substr(begin, end - begin));
}

/// A file and its frame; none of a single file, which is not a sequence.
struct Source {
  std::string path;
  std::optional<int> frame;
};

/// Does a name stand for a sequence? Not when a file has just that name.
bool isSequence(const std::string& name) {
  return FrameName(name).hasFrame() && !std::filesystem::exists(name);
}

/// The files of a name: of a sequence those that are there, or the frames asked for.
void add(const std::string& name, const SampleOptions& options, std::vector<Source>* sources) {
  const FrameName sequence(name);
  if (!isSequence(name)) {
    sources->push_back({name, frameNumber(name)});
  } else if (options.frames) {
    for (const int frame : *options.frames) sources->push_back({sequence.at(frame), frame});
  } else {
    for (auto& [frame, path] : sequence.files()) sources->push_back({std::move(path), frame});
  }
}

std::vector<Source> sourcesOf(const std::vector<std::string>& names, const SampleOptions& options) {
  if (names.size() == 1 && !isSequence(names[0])) {
    if (options.frames) throw InputError("frames", "are of names with a place for them");
    return {{names[0], std::nullopt}};
  }
  std::vector<Source> sources;
  for (const std::string& name : names) add(name, options, &sources);
  std::map<int, std::string> seen;
  for (const auto& [path, frame] : sources) {
    if (!frame) throw InputError(path, "", "has no frame number in its name");
    const auto [other, first] = seen.emplace(*frame, path);
    if (!first) {
      throw InputError(path, "",
                       "has frame number " + std::to_string(*frame) + ", as has " + other->second);
    }
  }
  return sources;
}

/// Sums of |a|^2 over indices, the same at any number of threads.
template <typename Of>
double sumOfSquares(std::size_t count, const Context& context, const Of& of) {
  constexpr std::size_t kBlock = 4096;
  std::vector<double> parts((count + kBlock - 1) / kBlock, 0.0);
  parallelFor<std::size_t>(
      parts.size(),
      [&](std::size_t b) {
        for (std::size_t k = b * kBlock; k < std::min(count, (b + 1) * kBlock); ++k) {
          parts[b] += of(k);
        }
      },
      context, 1);
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

template <int K>
class Sampler {
 public:
  Sampler(ControlAsset* asset, const SampleOptions& options, const Context& context)
      : asset_(asset),
        options_(options),
        context_(context),
        refiner_(asset->mesh, refinerOptions(), context.sub(0.1)),
        limit_(refiner_, context.sub(0.02)) {
    if (options_.closed) {
      const Array<Vec3>& x = asset->mesh.positions();
      projection_.emplace(complex(), x, fixedBy<K>(options_.boundary, complex(), x), context);
    }
  }

  SampleReport run(const std::vector<Source>& sources) {
    SampleReport report;
    Form form;
    form.name = options_.name;
    form.degree = K;
    form.unit = "1/s";
    for (Index k = 0; k < complex().count(K); ++k) form.simplices.push_back(k);
    form.signs.assign(form.simplices.size(), 1);
    for (const auto& [path, number] : sources) {
      context_.report({"sample", report.frames.size(), sources.size(), "files"});
      const VelocitySource source(path, options_.read, context_);
      SampledFrame frame = describe(path, number, source);
      const Cochain<K> coefficients = sample(source, &frame);
      measure(source, coefficients, &frame);
      std::vector<double> values(coefficients.values().begin(), coefficients.values().end());
      if (number) {
        form.frames.emplace(*number, std::move(values));
      } else {
        form.values = std::move(values);
      }
      report.sourceBytes += frame.bytes;
      report.frames.push_back(std::move(frame));
    }
    context_.report({"sample", sources.size(), sources.size(), "files"});
    put(std::move(form));
    return report;
  }

 private:
  const Complex& complex() const { return *asset_->mesh.complex(); }

  RefinerOptions refinerOptions() const {
    RefinerOptions result;
    result.levels = options_.levels;
    result.zeta = options_.zeta;
    return result;
  }

  static SampledFrame describe(const std::string& path, std::optional<int> number,
                               const VelocitySource& source) {
    SampledFrame frame;
    frame.path = path;
    frame.grid = source.gridName();
    frame.frame = number;
    frame.bytes = std::filesystem::file_size(path);
    frame.staggered = source.staggered();
    frame.voxelSize = source.voxelSize();
    frame.activeVoxels = source.activeVoxels();
    return frame;
  }

  double openness(const Cochain<K>& form) const {
    const double largest = maxNorm(form.values());
    return largest > 0 ? maxNorm(d(complex(), form).values()) / largest : 0;
  }

  Cochain<K> sample(const VelocitySource& source, SampledFrame* frame) const {
    const CompositeDeRham map(complex(), asset_->mesh.positions(), source.voxelSize(), context_);
    const auto at = [&](const Vec3& p) { return source.at(p); };
    Cochain<K> form;
    if constexpr (K == 1) {
      form = map.edges(at);
    } else {
      form = map.facets(at);
    }
    frame->before = openness(form);
    const Cochain<K> wanted = form;
    form = projected(std::move(form));
    for (int k = 0; k < options_.corrections; ++k) form = corrected(wanted, std::move(form));
    frame->after = openness(form);
    return form;
  }

  Cochain<K> projected(Cochain<K> form) const {
    return projection_ ? projection_->apply(form, fixesToZero(options_.boundary), context_) : form;
  }

  VectorField limitField(const Cochain<K>& form) const {
    const BoundaryMode mode = options_.closed && options_.boundary == BoundaryRule::ZeroInside
                                  ? BoundaryMode::Walls
                                  : automaticMode(complex(), form);
    return makeField(refiner_, limit_, refiner_.refine(form, mode, context_), mode,
                     Reconstruction::Limit, context_);
  }

  /// Adds what the limit field's own fluxes or circulations lack; nothing where a simplex reaches
  /// out of the limit surface, as on a curved boundary.
  Cochain<K> corrected(const Cochain<K>& wanted, Cochain<K> form) const {
    const VectorField field = limitField(form);
    // The limit is linear on the finest level.
    double edge = 0;
    for (const auto& [a, b] : refiner_.finest().edges) {
      edge = std::max(edge, (limit_.positions()[b] - limit_.positions()[a]).norm());
    }
    const CompositeDeRham map(complex(), asset_->mesh.positions(), edge, context_);
    const auto at = [&](const Vec3& p) {
      Vec3 v;
      return field.sample(p, &v) ? v : Vec3(Vec3::Constant(NAN));
    };
    Cochain<K> lack;
    if constexpr (K == 1) {
      lack = map.edges(at);
    } else {
      lack = map.facets(at);
    }
    for (Index k = 0; k < lack.size(); ++k) {
      lack[k] = std::isfinite(lack[k]) ? wanted[k] - lack[k] : 0.0;
    }
    lack = projected(std::move(lack));
    for (Index k = 0; k < lack.size(); ++k) form[k] += lack[k];
    return form;
  }

  void measure(const VelocitySource& source, const Cochain<K>& form, SampledFrame* frame) const {
    const std::vector<Vec3> points = source.voxelPositions(options_.mostPoints, context_);
    const VectorField field = limitField(form);
    std::vector<Vec3> values(points.size());
    std::vector<std::uint8_t> inside(points.size());
    field.sample(points.data(), points.size(), values.data(), inside.data(), context_);
    const std::size_t n = points.size();
    const double count =
        sumOfSquares(n, context_, [&](std::size_t k) { return inside[k] ? 1.0 : 0.0; });
    frame->inside = count / static_cast<double>(n);
    if (count == 0) {
      throw InputError(frame->path, "grid " + frame->grid, "no voxel lies in the cage");
    }
    const auto sum = [&](const auto& of) {
      return sumOfSquares(n, context_, [&](std::size_t k) { return inside[k] ? of(k) : 0.0; });
    };
    const double speeds = sum([&](std::size_t k) { return source.at(points[k]).squaredNorm(); });
    const double misses =
        sum([&](std::size_t k) { return (values[k] - source.at(points[k])).squaredNorm(); });
    const double divergences =
        sum([&](std::size_t k) { return std::pow(source.divergenceAt(points[k]), 2); });
    frame->speed = std::sqrt(speeds / count);
    if (!(speeds > 0)) return;
    frame->error = std::sqrt(misses / speeds);
    frame->sourceDivergence = source.voxelSize() * std::sqrt(divergences / speeds);
  }

  void put(Form form) {
    auto& forms = asset_->forms;
    const auto same = std::find_if(forms.begin(), forms.end(),
                                   [&](const Form& other) { return other.name == form.name; });
    if (same == forms.end()) {
      forms.push_back(std::move(form));
    } else {
      *same = std::move(form);
    }
  }

  ControlAsset* asset_;
  const SampleOptions& options_;
  const Context& context_;
  Refiner refiner_;
  Limit limit_;
  std::optional<ClosedProjection<K>> projection_;
};

}  // namespace

SampleReport sampleVelocity(ControlAsset* asset, const std::vector<std::string>& names,
                            const SampleOptions& options, const Context& context) {
  const std::vector<Source> sources = sourcesOf(names, options);
  if (sources.empty()) throw InputError("", "there are no velocity files");
  if (!std::isfinite(options.read.scale) || options.read.scale == 0) {
    throw InputError("scale", "is not a number other than 0");
  }
  if (!(options.read.framesPerSecond > 0) || !std::isfinite(options.read.framesPerSecond)) {
    throw InputError("frames per second", "is not a positive number");
  }
  if (options.corrections < 0) throw InputError("corrections", "are fewer than none");
  if (options.degree == 1) return Sampler<1>(asset, options, context).run(sources);
  if (options.degree == 2) return Sampler<2>(asset, options, context).run(sources);
  throw InputError("degree", std::to_string(options.degree) + " is neither 1 nor 2");
}

}  // namespace octet
