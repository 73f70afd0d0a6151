// SPDX-License-Identifier: Apache-2.0
// Speed of the core's stages, on one thread and on two:
//   core_bench --benchmark_filter='sample_grid/.*/500k'
#include <map>
#include <memory>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <octet/core/field/field.h>

#include "bench_meshes.h"

namespace octet::bench {
namespace {

using benchmark::Counter;
using benchmark::State;

constexpr std::size_t kPoints = 1 << 19;

const ControlMesh& cachedControlMesh(const std::string& name) {
  static std::map<std::string, ControlMesh> meshes;
  const auto found = meshes.find(name);
  return found != meshes.end() ? found->second
                               : meshes.emplace(name, controlMesh(name)).first->second;
}

/// Everything that a stage reads, prepared by the stages before it.
struct Scene {
  Scene(const std::string& mesh, const Size& size)
      : refiner(makeRefiner(cachedControlMesh(mesh), size.levels)),
        limit(refiner),
        field(makeField<2>(refiner, limit, testing::randomForm<2>(refiner.finest(), 1),
                           BoundaryMode::Open)),
        frame(frameOver(field.bounds())) {
    const auto random = testing::randomValues(3 * kPoints, 2);
    const Vec3 centre = (field.bounds().min + field.bounds().max) / 2;
    for (std::size_t k = 0; k < kPoints; ++k) {
      const Vec3 offset(random[3 * k], random[3 * k + 1], random[3 * k + 2]);
      points.push_back(centre + offset.cwiseProduct(field.bounds().size()) / 2);
    }
  }

  Refiner refiner;
  Limit limit;
  VectorField field;
  GridFrame frame;
  std::vector<Vec3> points;  ///< anywhere in the field's bounds
};

/// The scene of a mesh, kept until another is asked for: the largest need gigabytes.
const Scene& scene(const std::string& mesh, const Size& size) {
  static std::string cachedName;
  static std::unique_ptr<Scene> cached;
  const std::string name = mesh + "/" + size.name;
  if (name != cachedName) {
    cached.reset();
    cached = std::make_unique<Scene>(mesh, size);
    cachedName = name;
  }
  return *cached;
}

void setRate(State& state, const char* unit, double perIteration) {
  state.counters[unit] = Counter(perIteration, Counter::kIsIterationInvariantRate);
}

void build(State& state, const std::string& mesh, const Size& size) {
  const ControlMesh& control = cachedControlMesh(mesh);
  double cells = 0;
  for (auto _ : state) {
    const Refiner refiner = makeRefiner(control, size.levels);
    cells = refiner.finest().cellCount();
  }
  setRate(state, "cells/s", cells);
}

/// The last step, from coefficients on the level before the finest.
template <int K>
void apply(State& state, const std::string& mesh, const Size& size) {
  const Refiner& refiner = scene(mesh, size).refiner;
  const int level = refiner.levels() - 1;
  const Cochain<K> form = testing::randomForm<K>(refiner.complex(level), 1);
  for (auto _ : state) benchmark::DoNotOptimize(refiner.step(level, form, BoundaryMode::Open));
  setRate(state, "coefficients/s", refiner.finest().count(K));
}

template <int K>
void limitVectors(State& state, const std::string& mesh, const Size& size) {
  const Scene& s = scene(mesh, size);
  const Cochain<K> form = testing::randomForm<K>(s.refiner.finest(), 1);
  for (auto _ : state) benchmark::DoNotOptimize(s.limit.vectors(form, BoundaryMode::Open));
  setRate(state, "vertices/s", s.refiner.finest().vertexCount());
}

void sampleGrid(State& state, const std::string& mesh, const Size& size) {
  const Scene& s = scene(mesh, size);
  for (auto _ : state) {
    rasterize<3>(s.field.source(), s.frame, Sampling::Collocated,
                 [](const Tile<3>& tile) { benchmark::DoNotOptimize(tile.values[0][0]); });
  }
  setRate(state, "points/s", std::pow(kResolution, 3));
}

void samplePoints(State& state, const std::string& mesh, const Size& size) {
  const Scene& s = scene(mesh, size);
  std::vector<Vec3> values(kPoints);
  std::vector<std::uint8_t> inside(kPoints);
  // Cells are binned at the first call, which is left out.
  s.field.sample(s.points.data(), 1, values.data(), inside.data());
  for (auto _ : state) {
    s.field.sample(s.points.data(), kPoints, values.data(), inside.data());
    benchmark::DoNotOptimize(values.data());
  }
  setRate(state, "points/s", kPoints);
}

struct Stage {
  const char* name;
  void (*run)(State&, const std::string& mesh, const Size&);
};
constexpr Stage kStages[] = {{"build", build},
                             {"apply_1_form", apply<1>},
                             {"apply_2_form", apply<2>},
                             {"limit_1_form", limitVectors<1>},
                             {"limit_2_form", limitVectors<2>},
                             {"sample_grid", sampleGrid},
                             {"sample_points", samplePoints}};

/// stage/mesh/size/threads:n, those of one scene one after another.
void registerAll() {
  for (const Size& size : kSizes) {
    for (const std::string mesh : kMeshes) {
      for (const Stage& stage : kStages) {
        const auto run = [mesh, size, stage](State& state) {
          const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(state.range(0)));
          stage.run(state, mesh, size);
        };
        const std::string name = std::string(stage.name) + "/" + mesh + "/" + size.name;
        benchmark::RegisterBenchmark(name.c_str(), run)
            ->ArgName("threads")
            ->Arg(1)
            ->Arg(2)
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  octet::bench::registerAll();
  benchmark::RunSpecifiedBenchmarks();
}
