// SPDX-License-Identifier: Apache-2.0
#include "bake_plan.h"

#include <cmath>
#include <cstdio>

#include <octet/core/base/memory_budget.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/refine/cell_memory.h>
#include <octet/core/refine/most_levels.h>

#include "targets.h"
#include "wording.h"

namespace octet {
namespace {

/// Automatic levels refine until the mean fine edge is at most this many voxels.
constexpr double kVoxelsPerEdge = 2;
/// What a leaf of a grid takes besides its values, and its share of the nodes above it.
constexpr double kBytesPerLeaf = 200;
/// Samples along a leaf.
constexpr double kLeafSamples = 8;

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

/// Leaves of a grid, about; of a part of it, when that is asked for.
double foreseenLeaves(const BakeOptions& options, const MeshFacts& facts, double voxelSize) {
  const double leaf = kLeafSamples * voxelSize;
  // A leaf's samples span less than the leaf; staggered ones lie around voxels that are touched.
  const double reach =
      options.sampling == Sampling::Staggered ? leaf + voxelSize : leaf - voxelSize;
  double leaves = facts.domain.cubes(leaf, reach);
  if (options.shard) {
    constexpr double kUneven = 1.2;
    leaves *= std::min(1.0, kUneven / options.shard->count);
  } else if (options.region) {
    const Box region = turnedBox(*options.region, facts.turn), all = facts.domain.box();
    double most = 1;
    for (int k = 0; k < 3; ++k) {
      const double from = std::max(region.min[k], all.min[k]);
      most *= std::max(0.0, std::min(region.max[k], all.max[k]) - from) / leaf + 2;
    }
    leaves = std::min(leaves, most);
  }
  return leaves;
}

/// "950", "12 million".
std::string inWords(double count) {
  char text[32];
  const bool many = count >= 1e6;
  std::snprintf(text, sizeof text, count < 1e15 ? "%.0f" : "%.3g", many ? count / 1e6 : count);
  return text + std::string(many ? " million" : "");
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
  plan.meshBytes = (kOperatorBytesPerCell + kFieldBytesPerCell) * plan.cells;
  const double leaves = foreseenLeaves(options, facts, plan.voxelSize);
  const double samples = kLeafSamples * kLeafSamples * kLeafSamples;
  plan.voxels = std::min(facts.domain.volume() / std::pow(plan.voxelSize, 3), samples * leaves);
  const int components = facts.scalars + 3 * facts.vectors;
  plan.gridBytes = leaves * (samples * sizeof(float) * components +
                             kBytesPerLeaf * (facts.scalars + facts.vectors));
  return plan;
}

int largestResolution(const BakeOptions& options, const MeshFacts& facts, double memory) {
  BakeOptions tried = options;
  tried.voxelSize = 0;
  const auto fits = [&](int resolution) {
    tried.resolution = resolution;
    return planResolution(tried, facts).bytes() <= memory;
  };
  int most = 0, tooMany = 1 << 20;
  while (tooMany - most > 1) {
    const int middle = most + (tooMany - most) / 2;
    (fits(middle) ? most : tooMany) = middle;
  }
  return most;
}

void checkMemory(const ResolutionPlan& plan, const BakeOptions& options, const MeshFacts& facts,
                 double memory) {
  if (plan.bytes() <= memory) return;
  const int most = largestResolution(options, facts, memory);
  throw MemoryError(options.voxelSize != 0 ? "voxel size" : "resolution",
                    "about " + inWords(plan.voxels) + " voxels and " + inWords(plan.cells) +
                        " cells, of " + std::to_string(plan.levels) + " levels, need up to " +
                        inGigabytes(plan.bytes()) + " of memory; there are " + inGigabytes(memory) +
                        "; " +
                        (most > 0 ? "the largest resolution that fits is " + std::to_string(most)
                                  : "give fewer levels"),
                    plan.bytes(), memory);
}

AxisTurn turnFor(char upAxis, const BakeOptions& options) {
  const char target = findTarget(options.target).upAxis;
  return {upAxis, target ? target : upAxis};
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
  plan.turn = turnFor(facts.upAxis, options);
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
