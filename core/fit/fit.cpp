// SPDX-License-Identifier: Apache-2.0
#include "fit.h"

#include <algorithm>
#include <cmath>

#include "../base/parallel.h"
#include "../forms/coboundary.h"
#include "../topology/mean_edge.h"
#include "../hodge/coboundary_matrix.h"
#include "conflicts.h"
#include "influence.h"
#include "least_squares.h"
#include "smoothness.h"
#include "wall_potential.h"

namespace octet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

/// Samples along curves per mean control edge.
constexpr double kSamplesPerEdge = 4;

/// Weight of the gauge of a vector potential and of what remains free (harmonic parts), as a share
/// of the mean diagonal: the first changes no velocity, the second none that is seen.
constexpr double kGaugeShare = 1, kHarmonicShare = 1e-12;

/// Weight of no flow through the walls in a curl-free fit, against 1 for all guides.
constexpr double kWallWeight = 10;

Matrix identity(Eigen::Index n) {
  Matrix m(n, n);
  m.setIdentity();
  return m;
}

/// row * basis, for rows over coefficients and a basis from unknowns to coefficients.
std::vector<SparseRow> throughBasis(const std::vector<SparseRow>& rows, const RowMatrix& basis) {
  std::vector<SparseRow> result(rows.size());
  parallelRanges<std::size_t>(
      rows.size(),
      [&](std::size_t first, std::size_t last) {
        RowSum sum(static_cast<Index>(basis.cols()));
        for (std::size_t r = first; r < last; ++r) {
          for (std::size_t k = 0; k < rows[r].size(); ++k) {
            for (RowMatrix::InnerIterator it(basis, rows[r].index[k]); it; ++it) {
              sum.add(static_cast<Index>(it.col()), rows[r].weight[k] * it.value());
            }
          }
          result[r] = sum.take();
        }
      },
      256);
  return result;
}

double meanOfDiagonal(const Matrix& m) {
  return m.rows() > 0 ? m.diagonal().sum() / static_cast<double>(m.rows()) : 0;
}

RefinerOptions refinerOptions(const FitOptions& options) {
  RefinerOptions result;
  result.levels = options.levels;
  result.zeta = options.zeta;
  result.progress = options.progress;
  return result;
}

const FitOptions& checked(const FitOptions& options) {
  if (!(options.smoothness >= 0) || !std::isfinite(options.smoothness)) {
    throw InputError("smoothness", "is not a number that is 0 or more");
  }
  if (!(options.spacing >= 0) || !std::isfinite(options.spacing)) {
    throw InputError("spacing", "is not a number that is 0 or more");
  }
  if (options.kind == FitKind::CurlFree && !options.openFacets.empty()) {
    throw InputError("open facets", "are for fields that are fluxes, not for curl-free ones");
  }
  if (options.kind == FitKind::CurlFree && !options.flux.empty()) {
    throw InputError("given flux", "is for fields that are fluxes, not for curl-free ones");
  }
  return options;
}

}  // namespace

/// The control coefficients are basis x + particular, with x the unknowns.
struct Fit::State {
  State(const ControlMesh& mesh, const FitOptions& given)
      : options(checked(given)), mesh(mesh), refiner(mesh, refinerOptions(given)), limit(refiner) {
    edge = meanEdge(complex(), mesh.positions());
    length = options.smoothness * std::cbrt(volumeOf(complex(), mesh.positions()));
    if (options.kind == FitKind::CurlFree) {
      prepareCurlFree();
    } else {
      prepareFlux();
    }
  }

  const Complex& complex() const { return *mesh.complex(); }

  /// Flux along the stored orientation of facets that have a given one.
  GivenFlux givenFlux() const {
    const Complex& c = complex();
    GivenFlux result(static_cast<std::size_t>(c.facetCount()));
    for (Index f = 0; options.closedWalls && f < c.facetCount(); ++f) {
      if (c.facetOnBoundary(f)) result[f] = 0;
    }
    for (const Index f : options.openFacets) {
      if (f < 0 || f >= c.facetCount() || !c.facetOnBoundary(f)) {
        throw InputError("open facets", "facet " + std::to_string(f) + " is not on the boundary");
      }
      result[f].reset();
    }
    for (const auto& [f, outward] : options.flux) {
      if (f < 0 || f >= c.facetCount() || !c.facetOnBoundary(f)) {
        throw InputError("given flux", "facet " + std::to_string(f) + " is not on the boundary");
      }
      if (!std::isfinite(outward)) throw InputError("given flux", "is not a finite number");
      // The stored facet points out of the first of its cells.
      result[f] = c.facetCells[f][0].exists() ? outward : -outward;
    }
    return result;
  }

  void prepareFlux() {
    const Complex& c = complex();
    flux = givenFlux();
    std::vector<std::uint8_t> zero(static_cast<std::size_t>(c.facetCount()), 0);
    mode = BoundaryMode::Open;
    for (Index f = 0; f < c.facetCount(); ++f) {
      zero[f] = flux[f] && *flux[f] == 0;
      if (zero[f]) mode = BoundaryMode::Walls;
    }
    influence2.emplace(refiner, limit, mode, zero);
    const bool divergent = options.kind == FitKind::Free;
    const Matrix onFacets = smoothnessEnergy<2>(c, mesh.positions(), length, true, divergent);
    if (divergent) {
      std::vector<Eigen::Triplet<double>> entries;
      Index unknowns = 0;
      particular = Vector::Zero(c.facetCount());
      for (Index f = 0; f < c.facetCount(); ++f) {
        if (flux[f]) {
          particular[f] = *flux[f];
        } else {
          entries.emplace_back(f, unknowns++, 1.0);
        }
      }
      basis = RowMatrix(c.facetCount(), unknowns);
      basis.setFromTriplets(entries.begin(), entries.end());
    } else {
      const Matrix d1 = coboundaryMatrix<1>(c);
      potential = makeWallPotential(c, flux);
      basis = RowMatrix(d1 * potential.basis);
      particular = d1 * potential.particular;
      gauge = Matrix(potential.basis.transpose()) *
              Matrix(gaugeEnergy(c, mesh.positions(), potential.gaugeVertices) * potential.basis);
    }
    setEnergy(onFacets);
  }

  void prepareCurlFree() {
    const Complex& c = complex();
    mode = BoundaryMode::Open;
    influence1.emplace(refiner, limit, mode,
                       std::vector<std::uint8_t>(static_cast<std::size_t>(c.edgeCount()), 0));
    basis = RowMatrix(coboundaryMatrix<0>(c));
    particular = Vector::Zero(c.edgeCount());
    setEnergy(smoothnessEnergy<1>(c, mesh.positions(), length, false, true));
    if (options.closedWalls) prepareWallRows();
  }

  void setEnergy(const Matrix& onCoefficients) {
    const Matrix columns = basis;
    smoothness = options.smoothness > 0;
    if (!smoothness) {
      energy = Matrix(columns.cols(), columns.cols());
      energyPull = Vector::Zero(columns.cols());
      return;
    }
    const Matrix half = onCoefficients * columns;
    energy = Matrix(columns.transpose()) * half;
    energyPull = -(Matrix(half.transpose()) * particular);
  }

  /// Points on the walls at which a curl-free field should not pass.
  void prepareWallRows() {
    const Complex& c = refiner.finest();
    const Array<Vec3>& x = limit.positions();
    for (const Index f : refiner.boundary(refiner.levels()).facets) {
      const auto v = c.facetVertices(f);
      const Vec3 area = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 2;
      if (!(area.norm() > 0)) continue;
      wallPoints.push_back((x[v[0]] + x[v[1]] + x[v[2]]) / 3);
      wallAreas.push_back(area);
    }
    const auto at = influence1->at(wallPoints, options.progress);
    std::vector<SparseRow> normals;
    RowSum sum(complex().edgeCount());
    for (std::size_t k = 0; k < wallPoints.size(); ++k) {
      const Vec3 normal = wallAreas[k].normalized();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const SparseRow& row = at.rows[3 * k + axis];
        for (std::size_t j = 0; j < row.size(); ++j) {
          sum.add(row.index[j], normal[static_cast<Index>(axis)] * row.weight[j]);
        }
      }
      normals.push_back(sum.take());
    }
    wallRows = throughBasis(normals, basis);
    wallVectors = std::move(at.rows);
  }

  FitOptions options;
  ControlMesh mesh;
  Refiner refiner;
  Limit limit;
  double edge = 0, length = 0;
  BoundaryMode mode = BoundaryMode::Walls;
  GivenFlux flux;
  WallPotential potential;
  std::optional<Influence<1>> influence1;
  std::optional<Influence<2>> influence2;
  RowMatrix basis;
  Vector particular;
  bool smoothness = true;
  Matrix energy, gauge;
  Vector energyPull;
  std::vector<Vec3> wallPoints, wallAreas;
  std::vector<SparseRow> wallRows, wallVectors;
};

namespace {

/// One fit: equations from guides, solution, report.
template <typename State>
class Run {
 public:
  Run(const State& state, const Guides& guides) : s_(state), guides_(guides) {}

  FitResult run() {
    sample();
    findInfluence();
    LeastSquares problem = equations();
    const Matrix energy = regularised(problem);
    problem.energy = &energy;
    const LeastSquaresSolution solution = solve(problem, s_.options.progress);
    report_.unknowns = static_cast<Index>(s_.basis.cols());
    report_.direct = solution.direct;
    report_.iterations = solution.iterations;
    report_.solverResidual = solution.residual;
    if (!solution.determined) refuseUndetermined();
    const Vector coefficients = s_.basis * solution.x + s_.particular;
    FitResult result;
    result.mode = s_.mode;
    if (s_.options.kind == FitKind::CurlFree) {
      fillCirculation(solution.x, coefficients, &result);
    } else {
      fillFlux(solution.x, coefficients, &result);
    }
    measure(coefficients);
    remark();
    result.report = std::move(report_);
    return result;
  }

 private:
  void sample() {
    const double spacing = s_.options.spacing > 0 ? s_.options.spacing : s_.edge / kSamplesPerEdge;
    samples_ = sampleGuides(guides_, spacing, s_.edge);
    if (samples_.empty()) throw InputError("guides", "there are none");
    for (const GuideSample& sample : samples_) totalWeight_ += sample.weight;
  }

  void findInfluence() {
    std::vector<Vec3> points;
    for (const GuideSample& sample : samples_) points.push_back(sample.point);
    std::vector<std::uint8_t> inside;
    const auto take = [&](auto&& at) {
      rows_ = std::move(at.rows);
      inside = std::move(at.inside);
    };
    if (s_.influence1) {
      take(s_.influence1->at(points, s_.options.progress));
    } else {
      take(s_.influence2->at(points, s_.options.progress));
    }
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      if (!inside[k]) refuseOutside(samples_[k]);
    }
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
                         " equations for " + std::to_string(s_.basis.cols()) +
                         " unknowns; add guides, or smoothness");
  }

  LeastSquares equations() {
    LeastSquares problem;
    problem.rows = throughBasis(rows_, s_.basis);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const GuideSample& sample = samples_[r / 3];
      problem.weights.push_back(sample.weight / totalWeight_);
      problem.rights.push_back(sample.value[static_cast<Index>(r % 3)] -
                               rows_[r].apply(s_.particular.data()));
    }
    report_.equations = rows_.size();
    double area = 0;
    for (const Vec3& a : s_.wallAreas) area += a.norm();
    for (std::size_t k = 0; k < s_.wallRows.size(); ++k) {
      problem.rows.push_back(s_.wallRows[k]);
      problem.weights.push_back(kWallWeight * s_.wallAreas[k].norm() / area);
      problem.rights.push_back(0);
    }
    problem.energyPull = s_.energyPull;
    return problem;
  }

  /// Smoothness, and what changes no velocity but would leave unknowns open.
  Matrix regularised(const LeastSquares& problem) const {
    double data = 0;
    for (std::size_t r = 0; r < problem.rows.size(); ++r) {
      for (const double w : problem.rows[r].weight) data += problem.weights[r] * w * w;
    }
    const double n = std::max<double>(1, static_cast<double>(s_.basis.cols()));
    const double mean = data / n + meanOfDiagonal(s_.energy);
    Matrix result = s_.energy;
    if (s_.gauge.rows() > 0 && meanOfDiagonal(s_.gauge) > 0) {
      result += kGaugeShare * mean / meanOfDiagonal(s_.gauge) * s_.gauge;
    }
    // A constant added to a scalar potential, harmonic vector potentials: they make no velocity.
    if (s_.smoothness && s_.options.kind != FitKind::Free) {
      result += kHarmonicShare * mean * identity(s_.basis.cols());
    }
    return result;
  }

  static Array<double> values(const Vector& v) {
    return Array<double>(v.data(), v.data() + v.size());
  }

  void fillFlux(const Vector& x, const Vector& coefficients, FitResult* result) {
    Cochain<2> flux(values(coefficients));
    double largest = maxNorm(flux.values()), wall = 0;
    for (Index f = 0; f < flux.size(); ++f) {
      // Sums that are a wall's 0 or a given flux up to rounding: exactly that.
      if (!s_.flux[f]) continue;
      wall = std::max(wall, std::abs(flux[f] - *s_.flux[f]));
      flux[f] = *s_.flux[f];
    }
    report_.wallFlux = largest > 0 ? wall / largest : 0;
    report_.divergence = largest > 0 ? maxNorm(d(s_.complex(), flux).values()) / largest : 0;
    if (s_.options.kind == FitKind::DivergenceFree) {
      result->vectorPotential =
          Cochain<1>(values(s_.potential.basis * x + s_.potential.particular));
    }
    result->flux = std::move(flux);
  }

  void fillCirculation(const Vector& x, const Vector& coefficients, FitResult* result) {
    result->circulation = Cochain<1>(values(coefficients));
    result->potential = Cochain<0>(values(x));
    double through = 0, all = 0;
    for (std::size_t k = 0; k < s_.wallPoints.size(); ++k) {
      const double area = s_.wallAreas[k].norm();
      through += area * std::pow(s_.wallRows[k].apply(x.data()), 2);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        all += area * std::pow(s_.wallVectors[3 * k + axis].apply(coefficients.data()), 2);
      }
    }
    report_.wallFlux = all > 0 ? std::sqrt(through / all) : 0;
  }

  void measure(const Vector& coefficients) {
    const std::size_t guideCount = guides_.curves.size() + guides_.vectors.size();
    std::vector<double> missed(guideCount, 0), wanted(guideCount, 0), worst(guideCount, 0);
    double allMissed = 0, allWanted = 0;
    report_.guides.resize(guideCount);
    errors_.resize(samples_.size());
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const GuideSample& sample = samples_[k];
      Vec3 v;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        v[static_cast<Index>(axis)] = rows_[3 * k + axis].apply(coefficients.data());
      }
      errors_[k] = (v - sample.value).norm();
      const double miss = sample.weight * errors_[k] * errors_[k];
      const double want = sample.weight * sample.value.squaredNorm();
      missed[sample.guide] += miss;
      wanted[sample.guide] += want;
      worst[sample.guide] = std::max(worst[sample.guide], errors_[k]);
      allMissed += miss;
      allWanted += want;
      ++report_.guides[sample.guide].samples;
    }
    std::vector<double> lengths(guideCount, 0);
    for (const GuideSample& sample : samples_) lengths[sample.guide] += sample.weight;
    for (std::size_t g = 0; g < guideCount; ++g) {
      GuideReport& guide = report_.guides[g];
      guide.name = guideName(guides_, g);
      const double speed = std::sqrt(wanted[g] / lengths[g]);
      // A guide that wants the field at rest has no size of its own: take all guides'.
      const double unit = speed > 0 ? speed : std::sqrt(allWanted / totalWeight_);
      guide.residual = unit > 0 ? std::sqrt(missed[g] / lengths[g]) / unit : 0;
      guide.worst = unit > 0 ? worst[g] / unit : 0;
    }
    report_.residual = allWanted > 0 ? std::sqrt(allMissed / allWanted) : 0;
    report_.conflicts = findConflicts(guides_, samples_, errors_, s_.edge);
  }

  void remark() {
    const auto say = [&](std::string text) { report_.remarks.push_back(std::move(text)); };
    if (!report_.conflicts.empty()) {
      say(std::to_string(report_.conflicts.size()) +
          " places where guides contradict each other within half an edge of the cage");
    }
    if (report_.equations < static_cast<std::size_t>(report_.unknowns)) {
      say("under-determined by guides alone: " + std::to_string(report_.equations) +
          " equations for " + std::to_string(report_.unknowns) +
          " unknowns; smoothness decides the rest");
    }
    const double share = shareWithoutGuide();
    if (share > 0.5) {
      say(std::to_string(static_cast<int>(std::lround(100 * share))) +
          " % of the cage's vertices are more than two edges away from any guide");
    }
    if (s_.options.kind == FitKind::CurlFree && s_.options.closedWalls) {
      say("a curl-free field meets closed walls only nearly: see the flow through them");
    }
    if (s_.mode == BoundaryMode::Walls && !s_.options.flux.empty()) {
      say("bake with --boundary walls: the walls are closed beside facets with a given flux");
    }
    if (!report_.direct && report_.solverResidual > 1e-8) {
      say("the iterative solver stopped at a residual of " +
          std::to_string(report_.solverResidual));
    }
  }

  double shareWithoutGuide() const {
    const double reach = 2 * s_.edge;
    const Array<Vec3>& x = s_.mesh.positions();
    std::vector<std::uint8_t> far(x.size());
    parallelFor<std::size_t>(
        x.size(),
        [&](std::size_t v) {
          far[v] = std::none_of(samples_.begin(), samples_.end(), [&](const GuideSample& sample) {
            return (sample.point - x[v]).squaredNorm() < reach * reach;
          });
        },
        64);
    return static_cast<double>(std::count(far.begin(), far.end(), 1)) /
           static_cast<double>(far.size());
  }

  const State& s_;
  const Guides& guides_;
  std::vector<GuideSample> samples_;
  double totalWeight_ = 0;
  std::vector<SparseRow> rows_;  // over control coefficients
  std::vector<double> errors_;
  FitReport report_;
};

}  // namespace

Fit::Fit(const ControlMesh& mesh, const FitOptions& options)
    : state_(std::make_unique<State>(mesh, options)) {}
Fit::~Fit() = default;
Fit::Fit(Fit&&) noexcept = default;

FitResult Fit::solve(const Guides& guides) const { return Run<State>(*state_, guides).run(); }

}  // namespace octet
