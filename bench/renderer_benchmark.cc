// SPDX-License-Identifier: BSD-3-Clause
// Parts of the renderer, on a random scene: projection, binning, forward,
// backward. The counter "pairs" is splat-tile pairs per second.

#include <cmath>
#include <memory>

#include <benchmark/benchmark.h>

#include "splat/rasterizer.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

struct Fixture {
  explicit Fixture(const benchmark::State& state)
      : pool(static_cast<int>(state.range(1))),
        model(RandomModel(state.range(0), 3, 1)),
        camera(TestCamera(480, 270)) {
    // Splats as small as many of them need to be to cover the picture.
    const auto shrink = static_cast<float>(
        0.5 * std::log(static_cast<double>(model.size()) / 300));
    for (float& s : model.log_scales) s -= shrink;
    gradients.sh_degree = model.sh_degree;
    gradients.Resize(model.size());
    d_color = ImageF(camera.width, camera.height, 3, 0.01f);
  }

  ThreadPool pool;
  GaussianModel model;
  GaussianModel gradients;
  Pinhole camera;
  RenderOptions options;
  ImageF d_color;
  Rasterizer rasterizer;
  RasterImages images;
};

void BM_Project(benchmark::State& state) {
  Fixture f(state);
  Projector projector;
  Projection projection;
  for (auto _ : state) {
    projector.Project(
        f.model, f.camera, TestPose(), f.options, f.pool, &projection);
  }
  state.counters["visible"] = static_cast<double>(projection.size());
}

void BM_Bin(benchmark::State& state) {
  Fixture f(state);
  Projector projector;
  Projection projection;
  projector.Project(
      f.model, f.camera, TestPose(), f.options, f.pool, &projection);
  TileBins bins;
  for (auto _ : state) {
    BinSplats(
        projection.splats, f.camera.width, f.camera.height, f.pool, &bins);
  }
  state.counters["num_pairs"] = static_cast<double>(bins.num_pairs());
}

void BM_Forward(benchmark::State& state) {
  Fixture f(state);
  for (auto _ : state) {
    f.rasterizer.Forward(
        f.model, f.camera, TestPose(), f.options, {}, f.pool, &f.images);
  }
  state.counters["pairs"] =
      benchmark::Counter(static_cast<double>(f.rasterizer.bins().num_pairs()),
                         benchmark::Counter::kIsIterationInvariantRate);
}

void BM_Backward(benchmark::State& state) {
  Fixture f(state);
  f.rasterizer.Forward(
      f.model, f.camera, TestPose(), f.options, {}, f.pool, &f.images);
  for (auto _ : state) {
    f.rasterizer.Backward(
        f.model, {.color = &f.d_color}, f.images, f.pool, &f.gradients);
  }
  state.counters["pairs"] =
      benchmark::Counter(static_cast<double>(f.rasterizer.bins().num_pairs()),
                         benchmark::Counter::kIsIterationInvariantRate);
}

void Sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"gaussians", "threads"})
      ->Args({15000, 1})
      ->Args({15000, 2})
      ->Args({100000, 1})
      ->Args({100000, 2})
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}
BENCHMARK(BM_Project)->Apply(Sizes);
BENCHMARK(BM_Bin)->Apply(Sizes);
BENCHMARK(BM_Forward)->Apply(Sizes);
BENCHMARK(BM_Backward)->Apply(Sizes);

}  // namespace
}  // namespace freegs::splat
