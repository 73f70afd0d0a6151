// SPDX-License-Identifier: Apache-2.0
// Plans of bakes from facts alone: nothing is refined or baked here.
#include <gtest/gtest.h>

#include <octet/converters/vdb/bake_plan.h>
#include <octet/converters/vdb/wording.h>
#include <octet/core/base/memory_budget.h>
#include <octet/core/raster/flux_rasterizer.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

/// A mesh whose level 1 has 1000 cells with edges of 0.5, in a box of side 8.
const MeshFacts kMesh{1.1, 8, 0.5, 200, 0};

BakeOptions ofResolution(int resolution) {
  BakeOptions options;
  options.resolution = resolution;
  return options;
}

/// Voxels of this many fine edges: of 0.1.
BakeFacts factsAt(double voxelsPerEdge) {
  BakeFacts facts;
  facts.resolution.voxelSize = voxelsPerEdge * 0.1;
  facts.refinement.fineEdge = 0.1;
  return facts;
}
/// Where means are automatic, and where they are not.
constexpr double kMeans = 0.5, kTooFine = 0.2, kTooCoarse = 0.9;

FormFacts flow() {
  FormFacts form;
  form.name = form.grid = "velocity";
  form.degree = 2;
  form.hasPotential = true;
  return form;
}
FormFacts gradient() {
  FormFacts form = flow();
  form.degree = 1;
  return form;
}
NotClosed open(int degree) { return {degree, 0.5, 0.25, "tetrahedra[3]", Vec3(1, 2, 3)}; }

template <typename Reason>
bool says(const BakePlan& plan) {
  for (const BakeReason& reason : plan.reasons) {
    if (std::holds_alternative<Reason>(reason)) return true;
  }
  return false;
}

TEST(ResolutionPlan, RefinesUntilAnEdgeIsTwoVoxels) {
  for (const int resolution : {4, 20, 33, 64, 200}) {
    const ResolutionPlan plan = planResolution(ofResolution(resolution), kMesh);
    EXPECT_EQ(plan.voxelSize, 8.0 / resolution);
    EXPECT_LE(plan.fineEdge, 2 * plan.voxelSize);
    if (plan.levels == 0) continue;
    BakeOptions fewer = ofResolution(resolution);
    fewer.levels = plan.levels - 1;
    EXPECT_GT(planResolution(fewer, kMesh).fineEdge, 2 * plan.voxelSize);
  }
  EXPECT_EQ(planResolution(ofResolution(14), kMesh).levels, 0);
}

TEST(ResolutionPlan, ForeseesCellsAndMemory) {
  BakeOptions options = ofResolution(10);
  options.levels = 3;
  const ResolutionPlan plan = planResolution(options, kMesh);
  EXPECT_EQ(plan.levels, 3);
  EXPECT_EQ(plan.cells, 35200 + 16800);
  EXPECT_EQ(plan.fineEdge, 0.125);
  EXPECT_EQ(plan.meshBytes, 600 * plan.cells);
  EXPECT_NO_THROW(checkMemory(plan, options, kMesh, plan.bytes()));
  EXPECT_THROW(checkMemory(plan, options, kMesh, plan.bytes() - 1), MemoryError);
}

/// A box of sides 1, 2 and 4, with a grid of numbers and two of vectors.
MeshFacts boxOfGrids() {
  ControlMeshInput input = testing::creasedBox(1, 0, 1);
  for (Vec3& x : input.vertices) x = x.cwiseProduct(Vec3(1, 2, 4));
  const ControlMesh mesh = ControlMesh::build(std::move(input));
  MeshFacts facts{1, 4, 1, 6, 0};
  facts.domain = DomainShape(*mesh.complex(), mesh.positions(), facts.turn);
  facts.scalars = 1;
  facts.vectors = 2;
  return facts;
}

TEST(ResolutionPlan, ForeseesVoxelsAndGrids) {
  const MeshFacts facts = boxOfGrids();
  BakeOptions options = ofResolution(400);
  options.levels = 0;
  const ResolutionPlan plan = planResolution(options, facts);
  EXPECT_NEAR(plan.voxels, 100.0 * 200 * 400, 1);
  // Leaves that the box meets: one number and two vectors of four bytes each, and a little more.
  const double leaves = (100 / 8.0 + 1) * (200 / 8.0 + 1) * (400 / 8.0 + 1);
  const double values = 512 * 4 * (1 + 2 * 3);
  EXPECT_LT(plan.gridBytes, 1.05 * leaves * values);
  EXPECT_GT(plan.gridBytes, plan.voxels * 4 * (1 + 2 * 3));
  BakeOptions part = options;
  part.shard = Shard{1, 4};
  EXPECT_NEAR(planResolution(part, facts).gridBytes, 0.3 * plan.gridBytes, 1e-6 * plan.gridBytes);
  part.shard.reset();
  part.region = Box{facts.domain.box().min, facts.domain.box().min + Vec3(0.1, 0.1, 0.1)};
  EXPECT_LT(planResolution(part, facts).gridBytes, 0.02 * plan.gridBytes);
}

TEST(ResolutionPlan, TheLargestThatFitsIsNamed) {
  const MeshFacts facts = boxOfGrids();
  const double memory = 1e9;
  for (const std::optional<int> levels : {std::optional<int>(2), std::optional<int>()}) {
    BakeOptions options = ofResolution(5000);
    options.levels = levels;
    const int most = largestResolution(options, facts, memory);
    BakeOptions fitting = options;
    fitting.resolution = most;
    EXPECT_NO_THROW(checkMemory(planResolution(fitting, facts), fitting, facts, memory));
    ++fitting.resolution;
    EXPECT_THROW(checkMemory(planResolution(fitting, facts), fitting, facts, memory), MemoryError);
    try {
      checkMemory(planResolution(options, facts), options, facts, memory);
      FAIL();
    } catch (const MemoryError& e) {
      EXPECT_NE(
          std::string(e.what()).find("largest resolution that fits is " + std::to_string(most)),
          std::string::npos)
          << e.what();
      EXPECT_EQ(e.place(), "resolution");
      EXPECT_EQ(e.available(), memory);
    }
  }
  BakeOptions deep = ofResolution(10);
  deep.levels = 9;
  EXPECT_EQ(largestResolution(deep, facts, memory), 0);
}

TEST(ResolutionPlan, RefusesLevelsThatNobodyHas) {
  for (const int levels : {-1, 13, 40}) {
    BakeOptions options = ofResolution(10);
    options.levels = levels;
    EXPECT_THROW(planResolution(options, kMesh), InputError) << levels;
  }
}

TEST(ResolutionPlan, RefusesSizesThatAreNone) {
  BakeOptions both = ofResolution(10);
  both.voxelSize = 1;
  BakeOptions negative;
  negative.voxelSize = -1;
  for (const BakeOptions& options : {BakeOptions(), both, negative, ofResolution(-3)}) {
    EXPECT_THROW(planResolution(options, kMesh), InputError);
  }
}

TEST(BakePlan, CirculationsWhereTheyAreAsAccurate) {
  const BakePlan plan = planBake(flow(), {}, factsAt(kMeans));
  EXPECT_EQ(plan.method, GridMethod::Circulations);
  EXPECT_TRUE(plan.reasons.empty());
  EXPECT_EQ(plan.neighbours, neighbourWeight(factsAt(kMeans).voxelsPerEdge()));
  for (const double ratio : {kTooFine, kTooCoarse}) {
    const BakePlan other = planBake(flow(), {}, factsAt(ratio));
    EXPECT_EQ(other.method, GridMethod::Samples);
    ASSERT_TRUE(says<VoxelsUnlikeEdges>(other));
    EXPECT_NEAR(std::get<VoxelsUnlikeEdges>(other.reasons[0]).voxelsPerEdge, ratio, 1e-12);
    // Faces of a staggered grid have exact means whatever the size.
    BakeOptions staggered;
    staggered.sampling = Sampling::Staggered;
    EXPECT_EQ(planBake(flow(), staggered, factsAt(ratio)).method, GridMethod::Circulations);
    BakeOptions conservative;
    conservative.method = BakeMethod::Conservative;
    EXPECT_EQ(planBake(flow(), conservative, factsAt(ratio)).method, GridMethod::Circulations);
    EXPECT_EQ(planBake(gradient(), {}, factsAt(ratio)).method, GridMethod::Differences);
  }
}

TEST(BakePlan, PotentialsAreSoughtOnlyWhereTheyAreUsed) {
  EXPECT_TRUE(seeksPotential(2, {}, factsAt(kMeans)));
  EXPECT_FALSE(seeksPotential(2, {}, factsAt(kTooFine)));
  EXPECT_TRUE(seeksPotential(1, {}, factsAt(kTooFine)));
  EXPECT_FALSE(seeksPotential(0, {}, factsAt(kMeans)));
  EXPECT_FALSE(seeksPotential(3, {}, factsAt(kMeans)));
  BakeOptions whitney, samples;
  whitney.reconstruction = Reconstruction::Whitney;
  samples.method = BakeMethod::Samples;
  EXPECT_FALSE(seeksPotential(1, whitney, factsAt(kMeans)));
  EXPECT_FALSE(seeksPotential(2, samples, factsAt(kMeans)));
}

TEST(BakePlan, FormsWithoutPotentialAreSampledAndSayWhy) {
  FormFacts form = flow();
  form.hasPotential = false;
  form.flaw = open(2);
  const BakePlan plan = planBake(form, {}, factsAt(kMeans));
  EXPECT_EQ(plan.method, GridMethod::Samples);
  EXPECT_EQ(words(plan.reasons),
            "not closed: 0.5, or 0.25 of the largest coefficient, leaves tetrahedra[3] at (1, 2, "
            "3)");
  form.flaw = LeavesVoid{{{0.5, Vec3(1, 0, 0)}, {-0.5, Vec3(0, 1, 0)}}};
  EXPECT_TRUE(says<LeavesVoid>(planBake(form, {}, factsAt(kMeans))));
  BakeOptions conservative;
  conservative.method = BakeMethod::Conservative;
  EXPECT_THROW(planBake(form, conservative, factsAt(kMeans)), InputError);
  // That it is open matters more than the size of voxels.
  FormFacts unsought = flow();
  unsought.hasPotential = false;
  unsought.open = open(2);
  const BakePlan fine = planBake(unsought, {}, factsAt(kTooFine));
  EXPECT_TRUE(says<NotClosed>(fine));
  EXPECT_FALSE(says<VoxelsUnlikeEdges>(fine));
}

TEST(BakePlan, AHandleMattersToStaggeredGridsAlone) {
  FormFacts form = flow();
  form.flaw = AroundHandle{};
  BakeOptions options;
  EXPECT_FALSE(says<AroundHandle>(planBake(form, options, factsAt(kMeans))));
  options.sampling = Sampling::Staggered;
  const BakePlan plan = planBake(form, options, factsAt(kMeans));
  EXPECT_TRUE(says<AroundHandle>(plan));
  EXPECT_EQ(plan.method, GridMethod::Circulations);
}

TEST(BakePlan, BoundaryMethodsThatDoNotCommuteAreSampled) {
  BakeFacts facts = factsAt(kMeans);
  facts.refinement.commutes = facts.refinement.hasLimits = false;
  facts.refinement.methodLoses = "something is lost";
  FormFacts form = flow();
  form.hasPotential = false;
  form.projected = Projected{open(2), 0.01};
  BakeOptions options;
  const BakePlan plan = planBake(form, options, facts);
  EXPECT_EQ(plan.method, GridMethod::Samples);
  EXPECT_EQ(plan.reconstruction, Reconstruction::Whitney);
  EXPECT_TRUE(says<MethodLoses>(plan) && says<NoRefinedPotential>(plan) && says<Projected>(plan));
  options.method = BakeMethod::Samples;
  EXPECT_FALSE(says<NoRefinedPotential>(planBake(form, options, facts)));
  EXPECT_NO_THROW(checkMethod(options, facts.refinement));
  options.method = BakeMethod::Conservative;
  EXPECT_THROW(checkMethod(options, facts.refinement), InputError);
}

TEST(BakePlan, FollowsTheTarget) {
  const auto planFor = [](const char* target) {
    BakeOptions options;
    options.target = target;
    return planBake(flow(), options, factsAt(kMeans));
  };
  EXPECT_FALSE(planFor("openvdb").turn.changes());
  EXPECT_EQ(planFor("openvdb").shift, Vec3(Vec3::Zero()));
  EXPECT_EQ(planFor("houdini").turn.to, 'Y');
  EXPECT_EQ(planFor("blender").shift, Vec3(Vec3::Constant(-0.025)));
  EXPECT_THROW(planFor("nothing"), InputError);
}

TEST(BakePlan, ScalarsHaveNoMethod) {
  for (const int degree : {0, 3}) {
    FormFacts form;
    form.degree = degree;
    BakeOptions options;
    options.sampling = Sampling::Staggered;
    const BakePlan plan = planBake(form, options, factsAt(kMeans));
    EXPECT_EQ(plan.method, GridMethod::None);
    EXPECT_EQ(plan.sampling, Sampling::Collocated);
  }
}

}  // namespace
}  // namespace octet
