// SPDX-License-Identifier: BSD-3-Clause
// Parts of the renderer, on a random scene: projection, binning, forward and
// backward. Forward includes projection and binning. Counters: see
// SetPairCounters.

#include <benchmark/benchmark.h>

#include "bench/benchmark_scene.h"
#include "splat/projection/projection.h"
#include "splat/render/tile_bins.h"

namespace freegs::splat {
namespace {

void BM_Project(benchmark::State& state) {
  BenchmarkScene scene(state);
  Projector projector;
  Projection projection;
  for (auto _ : state) {
    projector.Project(scene.model,
                      scene.camera,
                      scene.pose,
                      scene.options,
                      scene.pool,
                      &projection);
  }
  state.counters["visible"] = static_cast<double>(projection.size());
}

void BM_Bin(benchmark::State& state) {
  BenchmarkScene scene(state);
  Projector projector;
  Projection projection;
  projector.Project(scene.model,
                    scene.camera,
                    scene.pose,
                    scene.options,
                    scene.pool,
                    &projection);
  TileBins bins;
  for (auto _ : state) {
    if (!BinSplats(projection,
                   scene.camera.width,
                   scene.camera.height,
                   scene.pool,
                   &bins)
             .ok()) {
      state.SkipWithError("too many pairs");
      break;
    }
  }
  const auto pairs = static_cast<double>(bins.num_pairs());
  state.counters["tile_pairs"] =
      benchmark::Counter(pairs, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["num_tile_pairs"] = pairs;
}

void Forward(BenchmarkScene& scene) {
  scene.rasterizer.Forward(scene.model,
                           scene.camera,
                           scene.pose,
                           scene.options,
                           {},
                           scene.pool,
                           &scene.images);
}

void BM_Forward(benchmark::State& state) {
  BenchmarkScene scene(state);
  const Stopwatch stopwatch;
  for (auto _ : state) Forward(scene);
  SetPairCounters(stopwatch, scene, state);
}

void BM_Backward(benchmark::State& state) {
  BenchmarkScene scene(state);
  const ImageF d_color(scene.camera.width, scene.camera.height, 3, 0.01f);
  Forward(scene);
  const Stopwatch stopwatch;
  for (auto _ : state) {
    scene.rasterizer.Backward(scene.model,
                              {.color = &d_color},
                              scene.images,
                              scene.pool,
                              &scene.gradients);
  }
  SetPairCounters(stopwatch, scene, state);
}

BENCHMARK(BM_Project)->Apply(StandardSizes);
BENCHMARK(BM_Bin)->Apply(StandardSizes);
BENCHMARK(BM_Forward)->Apply(StandardSizes);
BENCHMARK(BM_Backward)->Apply(StandardSizes);

}  // namespace
}  // namespace freegs::splat
