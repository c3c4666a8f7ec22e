// SPDX-License-Identifier: BSD-3-Clause
// The random scene that the benchmarks of renderer and training step look at,
// and what they count.

#ifndef FREEGS_BENCH_BENCHMARK_SCENE_H_
#define FREEGS_BENCH_BENCHMARK_SCENE_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <numeric>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/render/rasterizer.h"
#include "splat/scene/spatial_order.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {

// Arguments: Gaussians, image width, image height, threads. Splats are as small
// as so many of them need to be to cover the picture: twice the Gaussians cover
// it as often, but for the low-pass filter's width.
struct BenchmarkScene {
  explicit BenchmarkScene(const benchmark::State& state)
      : pool(static_cast<int>(state.range(3))),
        model(RandomSceneModel(static_cast<size_t>(state.range(0)), 3, 1)),
        camera(TestCamera(static_cast<int>(state.range(1)),
                          static_cast<int>(state.range(2)))),
        pose(TestPose()) {
    const auto shrink = static_cast<float>(
        0.5 * std::log(static_cast<double>(model.size()) / 300));
    for (float& s : model.log_scales) s -= shrink;
    model.Select(MortonOrder(model));  // As training keeps it.
    gradients.sh_degree = model.sh_degree;
    gradients.Resize(model.size());
  }

  ThreadPool pool;
  GaussianModel model;
  GaussianModel gradients;
  Pinhole camera;
  Rigid3d pose;
  RenderOptions options;
  Rasterizer rasterizer;
  RasterImages images;
};

// Pairs of a Gaussian and a pixel that it is blended into: alpha is at least
// 1/255 and the pixel not opaque yet.
inline double CountGaussianPixels(BenchmarkScene& scene) {
  Rasterizer rasterizer;
  ViewContributions contributions;
  rasterizer.Contributions(scene.model,
                           scene.camera,
                           scene.pose,
                           scene.options,
                           /*mask=*/nullptr,
                           scene.pool,
                           &contributions);
  return std::accumulate(
      contributions.num_pixels.begin(), contributions.num_pixels.end(), 0.0);
}

// Time and CPU time of all threads since construction, seconds.
class Stopwatch {
 public:
  double Seconds() const { return Now(CLOCK_MONOTONIC) - start_; }
  double CpuSeconds() const {
    return Now(CLOCK_PROCESS_CPUTIME_ID) - cpu_start_;
  }

 private:
  static double Now(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) +
           1e-9 * static_cast<double>(time.tv_nsec);
  }

  double start_ = Now(CLOCK_MONOTONIC);
  double cpu_start_ = Now(CLOCK_PROCESS_CPUTIME_ID);
};

// Call it right after the loop, with a stopwatch started right before it.
// tile_pairs, gaussian_pixels: splat-tile and Gaussian-pixel pairs per second;
// ns_per_gp, cpu_ns_per_gp: nanoseconds of time and of CPU time per
// Gaussian-pixel pair; num_gp: such pairs in the view.
inline void SetPairCounters(const Stopwatch& stopwatch,
                            BenchmarkScene& scene,
                            benchmark::State& state) {
  using benchmark::Counter;
  const double seconds = stopwatch.Seconds();
  const double cpu_seconds = stopwatch.CpuSeconds();
  const auto tile_pairs =
      static_cast<double>(scene.rasterizer.bins().num_pairs());
  const double pixels = CountGaussianPixels(scene);
  state.counters["tile_pairs"] =
      Counter(tile_pairs, Counter::kIsIterationInvariantRate);
  state.counters["gaussian_pixels"] =
      Counter(pixels, Counter::kIsIterationInvariantRate);
  state.counters["ns_per_gp"] =
      Counter(1e9 * seconds / pixels, Counter::kAvgIterations);
  state.counters["cpu_ns_per_gp"] =
      Counter(1e9 * cpu_seconds / pixels, Counter::kAvgIterations);
  state.counters["num_gp"] = pixels;
}

// 15k, 100k and 240k Gaussians at 480 x 270, each with 1, 2, 4, ... threads, as
// many as the processor runs at once.
inline void StandardSizes(benchmark::internal::Benchmark* b) {
  std::vector<int64_t> threads;
  const int64_t most = std::max(1u, std::thread::hardware_concurrency());
  for (int64_t count = 1; count <= most; count *= 2) threads.push_back(count);
  b->ArgNames({"gaussians", "width", "height", "threads"})
      ->ArgsProduct({{15000, 100000, 240000}, {480}, {270}, threads})
      ->MeasureProcessCPUTime()
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace freegs::splat

#endif  // FREEGS_BENCH_BENCHMARK_SCENE_H_
