// SPDX-License-Identifier: BSD-3-Clause
// Blending weights, as a matrix and of one pixel, and products with it, on a
// random scene at the size features are learnt at. Arguments: see
// BenchmarkScene; channels of the products. num_weights: entries of the matrix;
// ns_per_weight: time per entry.

#include <vector>

#include <benchmark/benchmark.h>

#include "bench/benchmark_scene.h"
#include "splat/weights/blending_products.h"
#include "splat/weights/pixel_weights.h"

namespace freegs::splat {
namespace {

BlendingWeights WeightsOf(BenchmarkScene& scene) {
  return *ComputeBlendingWeights(
      scene.model, scene.camera, scene.pose, scene.options, scene.pool);
}

void SetWeightCounters(const Stopwatch& stopwatch,
                       double num_weights,
                       benchmark::State& state) {
  state.counters["num_weights"] = num_weights;
  state.counters["ns_per_weight"] =
      benchmark::Counter(1e9 * stopwatch.Seconds() / num_weights,
                         benchmark::Counter::kAvgIterations);
}

void BM_ComputeBlendingWeights(benchmark::State& state) {
  BenchmarkScene scene(state);
  double num_weights = 0;
  const Stopwatch stopwatch;
  for (auto _ : state) {
    num_weights = static_cast<double>(WeightsOf(scene).weights.size());
  }
  SetWeightCounters(stopwatch, num_weights, state);
}

// One pixel only: a click.
void BM_ComputePixelWeights(benchmark::State& state) {
  BenchmarkScene scene(state);
  for (auto _ : state) {
    benchmark::DoNotOptimize(ComputePixelWeights(scene.model,
                                                 scene.camera,
                                                 scene.pose,
                                                 scene.options,
                                                 scene.camera.width / 2,
                                                 scene.camera.height / 2,
                                                 scene.pool));
  }
}

void BM_Multiply(benchmark::State& state) {
  BenchmarkScene scene(state);
  const auto channels = static_cast<int>(state.range(4));
  const BlendingWeights weights = WeightsOf(scene);
  const WeightMatrix matrix = weights.matrix();
  const std::vector<float> features(scene.model.size() * channels, 0.5f);
  std::vector<float> pixels(matrix.num_pixels() * channels);
  const Stopwatch stopwatch;
  for (auto _ : state) {
    const Status status =
        Multiply(matrix, features, channels, scene.pool, pixels);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
  }
  SetWeightCounters(
      stopwatch, static_cast<double>(matrix.num_weights()), state);
}

void BM_AddMultiplyTransposed(benchmark::State& state) {
  BenchmarkScene scene(state);
  const auto channels = static_cast<int>(state.range(4));
  const BlendingWeights weights = WeightsOf(scene);
  const WeightMatrix matrix = weights.matrix();
  const std::vector<float> pixels(matrix.num_pixels() * channels, 0.5f);
  std::vector<float> sums(scene.model.size() * channels);
  const Stopwatch stopwatch;
  for (auto _ : state) {
    const Status status =
        AddMultiplyTransposed(matrix, pixels, channels, scene.pool, sums);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
  }
  SetWeightCounters(
      stopwatch, static_cast<double>(matrix.num_weights()), state);
}

void Views(benchmark::internal::Benchmark* b) {
  b->ArgNames({"gaussians", "width", "height", "threads"})
      ->ArgsProduct({{15000, 100000}, {224}, {126}, {1, 2}})
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

void ViewsAndChannels(benchmark::internal::Benchmark* b) {
  b->ArgNames({"gaussians", "width", "height", "threads", "channels"})
      ->ArgsProduct({{15000, 100000}, {224}, {126}, {1, 2}, {128, 512}})
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

BENCHMARK(BM_ComputeBlendingWeights)->Apply(Views);
BENCHMARK(BM_ComputePixelWeights)->Apply(Views);
BENCHMARK(BM_Multiply)->Apply(ViewsAndChannels);
BENCHMARK(BM_AddMultiplyTransposed)->Apply(ViewsAndChannels);

}  // namespace
}  // namespace freegs::splat
