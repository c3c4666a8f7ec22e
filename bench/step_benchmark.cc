// SPDX-License-Identifier: BSD-3-Clause
// One whole training step without files: forward, loss, backward, Adam. Also
// how it grows with pixels and with Gaussians that cover the picture as often.

#include <cstdint>
#include <span>

#include <benchmark/benchmark.h>

#include "bench/benchmark_scene.h"
#include "splat/optim/adam.h"
#include "splat/optim/learning_rates.h"
#include "splat/optim/loss.h"
#include "splat/train/stability.h"
#include "tests/random_image.h"

namespace freegs::splat {
namespace {

void BM_TrainingStep(benchmark::State& state) {
  BenchmarkScene scene(state);
  const ImageF target =
      RandomImage(scene.camera.width, scene.camera.height, 3, 1);
  PhotometricLoss loss;
  ImageF d_color;
  Adam adam;
  adam.Reset(scene.model);
  // The work must not change from step to step: Gaussians stay where they are.
  const LearningRates rates = {};
  const Stopwatch stopwatch;
  for (auto _ : state) {
    scene.rasterizer.Forward(scene.model,
                             scene.camera,
                             scene.pose,
                             scene.options,
                             {},
                             scene.pool,
                             &scene.images);
    benchmark::DoNotOptimize(
        loss.Compute(scene.images.color, target, scene.pool, &d_color));
    adam.BeginStep(rates);
    scene.rasterizer.BackwardInChunks(
        scene.model,
        {.color = &d_color},
        scene.images,
        scene.pool,
        [&](std::span<const uint32_t> visible, const GaussianGradients& rows) {
          adam.UpdateRows(visible, rows, &scene.model);
          BoundParameters(1.0, visible, &scene.model);
        });
    benchmark::ClobberMemory();
  }
  SetPairCounters(stopwatch, scene, state);
}
BENCHMARK(BM_TrainingStep)->Apply(StandardSizes);

// Twice the pixels, twice the Gaussians, both; one thread.
void ScalingSizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"gaussians", "width", "height", "threads"});
  for (const int64_t gaussians : {15000, 30000, 60000, 120000, 240000}) {
    b->Args({gaussians, 480, 270, 1})->Args({gaussians, 680, 382, 1});
  }
  b->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);
}
BENCHMARK(BM_TrainingStep)->Name("BM_TrainingStepScaling")->Apply(ScalingSizes);

}  // namespace
}  // namespace freegs::splat
