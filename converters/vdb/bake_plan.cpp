// SPDX-License-Identifier: Apache-2.0
#include "bake_plan.h"

#include <cmath>

#include <octet/core/base/memory_budget.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/refine/most_levels.h>

#include "targets.h"
#include "wording.h"

namespace octet {
namespace {

/// Automatic levels refine until the mean fine edge is at most this many voxels.
constexpr double kVoxelsPerEdge = 2;
/// What a cell of the finest level takes in memory, at most (tests/bench/memory.cpp).
constexpr double kBytesPerCell = 600;

double planVoxelSize(const BakeOptions& options, const MeshFacts& facts) {
  const bool bySize = options.voxelSize != 0, byCount = options.resolution != 0;
  if (bySize == byCount) {
    throw InputError("voxel size", bySize ? "is given twice, also as a resolution"
                                          : "is missing: give it or a resolution");
  }
  if (bySize) {
    if (!(options.voxelSize > 0) || !std::isfinite(options.voxelSize)) {
      throw InputError("voxel size", "is not a positive number");
    }
    return options.voxelSize;
  }
  if (options.resolution < 1) throw InputError("resolution", "is less than 1");
  return facts.longestSide / options.resolution;
}

/// A level halves edges.
double foreseenEdge(const MeshFacts& facts, int level) {
  return level == 0 ? facts.controlEdge : std::ldexp(facts.firstEdge, 1 - level);
}

/// By the split (SCHEME.md section 3), as a number: more levels can be asked for than fit.
double cellsAt(const MeshFacts& facts, int level) {
  double tets = facts.tets, octs = facts.octs;
  for (int k = 0; k < level; ++k) {
    const double inner = tets;
    tets = 4 * tets + 8 * octs;
    octs = inner + 6 * octs;
  }
  return tets + octs;
}

int automaticLevels(const MeshFacts& facts, double voxelSize) {
  int levels = 0;
  while (foreseenEdge(facts, levels) > kVoxelsPerEdge * voxelSize) ++levels;
  return levels;
}

bool isVector(int degree) { return degree == 1 || degree == 2; }

bool limitFields(const BakeOptions& options, const RefinementFacts& refinement) {
  return options.reconstruction == Reconstruction::Limit && refinement.hasLimits;
}

/// Potentials go with limits alone, and only where the derivative of a refined one is the refined
/// derivative: of the thesis' boundary methods, with expansion.
bool mayConserve(const BakeOptions& options, const RefinementFacts& refinement) {
  return options.method != BakeMethod::Samples && limitFields(options, refinement) &&
         refinement.commutes;
}

/// Are means of circulations less accurate than samples? On a collocated grid, unless they are
/// asked for.
std::optional<VoxelsUnlikeEdges> meansAreWorse(const BakeOptions& options, double voxelsPerEdge) {
  if (options.sampling == Sampling::Staggered || options.method == BakeMethod::Conservative ||
      (voxelsPerEdge >= kFinestMeans && voxelsPerEdge <= kCoarsestMeans)) {
    return std::nullopt;
  }
  return VoxelsUnlikeEdges{voxelsPerEdge, kFinestMeans, kCoarsestMeans};
}

BakeReason asReason(const VelocityPlan::Flaw& flaw) {
  return std::visit([](const auto& f) { return BakeReason(f); }, flaw);
}

/// Chooses the method of a vector grid, and says why.
void planVectors(const FormFacts& form, const BakeOptions& options, const BakeFacts& facts,
                 BakePlan* plan) {
  plan->sampling = options.sampling;
  plan->method = GridMethod::Samples;
  if (seeksPotential(form.degree, options, facts)) {
    // With a potential, a flaw is about voxels that only staggered grids leave out.
    if (form.flaw && (!form.hasPotential || options.sampling == Sampling::Staggered)) {
      plan->reasons.push_back(asReason(*form.flaw));
    }
    if (form.hasPotential) {
      plan->method = form.degree == 2 ? GridMethod::Circulations : GridMethod::Differences;
      plan->neighbours = neighbourWeight(facts.voxelsPerEdge());
    }
  } else if (form.open) {
    plan->reasons.push_back(*form.open);
  } else if (mayConserve(options, facts.refinement)) {
    plan->reasons.push_back(*meansAreWorse(options, facts.voxelsPerEdge()));
  }
}

}  // namespace

ResolutionPlan planResolution(const BakeOptions& options, const MeshFacts& facts) {
  ResolutionPlan plan;
  plan.voxelSize = planVoxelSize(options, facts);
  plan.levels = options.levels ? *options.levels : automaticLevels(facts, plan.voxelSize);
  if (options.levels && (plan.levels < 0 || plan.levels > kMostLevels)) {
    throw InputError("levels", std::to_string(plan.levels) + " is not between 0 and " +
                                   std::to_string(kMostLevels));
  }
  plan.cells = cellsAt(facts, plan.levels);
  plan.fineEdge = foreseenEdge(facts, plan.levels);
  plan.bytes = kBytesPerCell * plan.cells;
  return plan;
}

void checkMemory(const ResolutionPlan& plan, double memory) {
  if (plan.bytes <= memory) return;
  throw MemoryError("levels",
                    std::to_string(plan.levels) + " would make about " +
                        std::to_string(std::llround(plan.cells / 1e6)) +
                        " million cells, which need up to " + inGigabytes(plan.bytes) +
                        " of memory; there are " + inGigabytes(memory) +
                        "; give fewer --levels or larger voxels",
                    plan.bytes, memory);
}

void checkMethod(const BakeOptions& options, const RefinementFacts& refinement) {
  if (options.method == BakeMethod::Conservative && !mayConserve(options, refinement)) {
    throw InputError("method",
                     "conservative needs the limit reconstruction, and a boundary that commutes "
                     "with d: auto, walls, open, or expansion where the mesh has no narrow gaps");
  }
}

bool seeksPotential(int degree, const BakeOptions& options, const BakeFacts& facts) {
  if (!isVector(degree) || !mayConserve(options, facts.refinement)) return false;
  return degree == 1 || !meansAreWorse(options, facts.voxelsPerEdge());
}

BakePlan planBake(const FormFacts& form, const BakeOptions& options, const BakeFacts& facts) {
  const Target& target = findTarget(options.target);
  BakePlan plan;
  plan.form = form.name;
  plan.unit = form.unit;
  plan.grid = form.grid;
  plan.degree = form.degree;
  plan.resolution = facts.resolution;
  plan.turn = {facts.upAxis, target.upAxis ? target.upAxis : facts.upAxis};
  if (target.voxelCornered) plan.shift = Vec3::Constant(-facts.resolution.voxelSize / 2);
  plan.mode = form.mode;
  plan.boundaryRule = facts.refinement.boundaryRule;
  if (!limitFields(options, facts.refinement)) plan.reconstruction = Reconstruction::Whitney;
  if (!isVector(form.degree)) return plan;
  if (!facts.refinement.methodLoses.empty()) {
    plan.reasons.push_back(MethodLoses{facts.refinement.methodLoses});
    if (options.method != BakeMethod::Samples) plan.reasons.push_back(NoRefinedPotential{});
  }
  if (form.projected) plan.reasons.push_back(*form.projected);
  planVectors(form, options, facts, &plan);
  if (options.method == BakeMethod::Conservative && plan.method == GridMethod::Samples) {
    const std::string why = words(plan.reasons);
    throw InputError("form \"" + form.name + "\"", "cannot be baked by method conservative: " +
                                                       (why.empty() ? "it has no potential" : why));
  }
  return plan;
}

}  // namespace octet
