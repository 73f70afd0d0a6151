// SPDX-License-Identifier: Apache-2.0
#include "fit.h"

#include <algorithm>
#include <cmath>

#include "conflicts.h"
#include "fitted_field.h"
#include "guide_errors.h"

namespace octet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Samples along curves per mean control edge.
constexpr double kSamplesPerEdge = 4;

/// Weight of the gauge of a vector potential and of what remains free (harmonic parts), as a share
/// of the mean diagonal: the first changes no velocity, the second none that is seen.
constexpr double kGaugeShare = 1, kHarmonicShare = 1e-12;

Matrix identity(Eigen::Index n) {
  Matrix m(n, n);
  m.setIdentity();
  return m;
}

double meanOfDiagonal(const Matrix& m) {
  return m.rows() > 0 ? m.diagonal().sum() / static_cast<double>(m.rows()) : 0;
}

/// One fit: equations from guides, solution, report.
class FitRun {
 public:
  FitRun(const FitDomain& domain, const FittedField& field, const Guides& guides,
         const Context& context)
      : domain_(domain), field_(field), space_(field.space()), guides_(guides), context_(context) {}

  FitResult run() {
    sample();
    findInfluence();
    LeastSquares problem = equations();
    const Matrix energy = regularised(problem);
    problem.energy = &energy;
    const LeastSquaresSolution solution = solve(problem, context_);
    if (!solution.determined) refuseUndetermined();
    const Eigen::VectorXd coefficients = space_.basis * solution.x + space_.particular;
    FitResult result;
    result.mode = field_.mode();
    FitReport& report = result.report;
    report.equations = rows_.size();
    report.unknowns = static_cast<Index>(space_.basis.cols());
    report.direct = solution.direct;
    report.iterations = solution.iterations;
    report.solverResidual = solution.residual;
    field_.store(solution.x, coefficients, &result);
    measure(coefficients, &report);
    remark(&report);
    return result;
  }

 private:
  void sample() {
    const double spacing =
        domain_.options.spacing > 0 ? domain_.options.spacing : domain_.edge / kSamplesPerEdge;
    samples_ = sampleGuides(guides_, spacing, domain_.edge);
    if (samples_.empty()) throw InputError("guides", "there are none");
  }

  void findInfluence() {
    std::vector<Vec3> points;
    for (const GuideSample& sample : samples_) points.push_back(sample.point);
    InfluenceRows influence = field_.at(points, context_.sub(0.3));
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      if (!influence.inside[k]) refuseOutside(samples_[k]);
    }
    rows_ = std::move(influence.rows);
  }

  [[noreturn]] void refuseOutside(const GuideSample& sample) const {
    char at[128];
    std::snprintf(at, sizeof at, "lies outside the cage's limit surface at (%.6g, %.6g, %.6g)",
                  sample.point[0], sample.point[1], sample.point[2]);
    if (sample.guide < guides_.curves.size()) {
      const GuideCurve& curve = guides_.curves[sample.guide];
      throw InputError(curve.file, guidePlace(curve, sample.row), at);
    }
    const GuideVector& vector = guides_.vectors[sample.guide - guides_.curves.size()];
    throw InputError(vector.file,
                     vector.place.empty() ? "guide \"" + vector.name + "\"" : vector.place, at);
  }

  [[noreturn]] void refuseUndetermined() const {
    throw InputError("guides",
                     "do not determine the field: " + std::to_string(3 * samples_.size()) +
                         " equations for " + std::to_string(space_.basis.cols()) +
                         " unknowns; add guides, or smoothness");
  }

  LeastSquares equations() const {
    double totalWeight = 0;
    for (const GuideSample& sample : samples_) totalWeight += sample.weight;
    LeastSquares problem;
    problem.rows = throughBasis(rows_, space_, context_);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const GuideSample& sample = samples_[r / 3];
      problem.weights.push_back(sample.weight / totalWeight);
      problem.rights.push_back(sample.value[static_cast<Index>(r % 3)] -
                               rows_[r].apply(space_.particular.data()));
    }
    field_.addEquations(&problem);
    problem.energyPull = space_.energyPull;
    return problem;
  }

  /// Smoothness, and what changes no velocity but would leave unknowns open.
  Matrix regularised(const LeastSquares& problem) const {
    double data = 0;
    for (std::size_t r = 0; r < problem.rows.size(); ++r) {
      for (const double w : problem.rows[r].weight) data += problem.weights[r] * w * w;
    }
    const double n = std::max<double>(1, static_cast<double>(space_.basis.cols()));
    const double mean = data / n + meanOfDiagonal(space_.energy);
    Matrix result = space_.energy;
    const double gauge = meanOfDiagonal(space_.gauge);
    if (gauge > 0) result += kGaugeShare * mean / gauge * space_.gauge;
    if (space_.hasSilentUnknowns) result += kHarmonicShare * mean * identity(space_.basis.cols());
    return result;
  }

  void measure(const Eigen::VectorXd& coefficients, FitReport* report) const {
    std::vector<double> errors(samples_.size());
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      Vec3 v;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        v[static_cast<Index>(axis)] = rows_[3 * k + axis].apply(coefficients.data());
      }
      errors[k] = (v - samples_[k].value).norm();
    }
    reportErrors(guides_, samples_, errors, report);
    report->conflicts = findConflicts(guides_, samples_, errors, domain_.edge);
  }

  void remark(FitReport* report) const {
    const auto say = [&](std::string text) {
      if (!text.empty()) report->remarks.push_back(std::move(text));
    };
    if (!report->conflicts.empty()) {
      say(std::to_string(report->conflicts.size()) +
          " places where guides contradict each other within half an edge of the cage");
    }
    if (report->equations < static_cast<std::size_t>(report->unknowns)) {
      say("under-determined by guides alone: " + std::to_string(report->equations) +
          " equations for " + std::to_string(report->unknowns) +
          " unknowns; smoothness decides the rest");
    }
    const double share = shareFarFrom(samples_, domain_.mesh.positions(), 2 * domain_.edge);
    if (share > 0.5) {
      say(std::to_string(static_cast<int>(std::lround(100 * share))) +
          " % of the cage's vertices are more than two edges away from any guide");
    }
    say(field_.remark());
    if (!report->direct && report->solverResidual > 1e-8) {
      say("the iterative solver stopped at a residual of " +
          std::to_string(report->solverResidual));
    }
  }

  const FitDomain& domain_;
  const FittedField& field_;
  const FitSpace& space_;
  const Guides& guides_;
  const Context& context_;
  std::vector<GuideSample> samples_;
  std::vector<SparseRow> rows_;  // of the samples, over control coefficients
};

}  // namespace

Fit::Fit(const ControlMesh& mesh, const FitOptions& options, const Context& context)
    : domain_(std::make_unique<FitDomain>(mesh, options, context)),
      field_(options.kind == FitKind::CurlFree ? makeCurlFreeFit(*domain_, context)
                                               : makeFluxFit(*domain_, context)) {}
Fit::~Fit() = default;
Fit::Fit(Fit&&) noexcept = default;

FitResult Fit::solve(const Guides& guides, const Context& context) const {
  return FitRun(*domain_, *field_, guides, context).run();
}

}  // namespace octet
