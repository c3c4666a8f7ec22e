// SPDX-License-Identifier: BSD-3-Clause
// Parts of a training step of the splats: loss and optimiser. The renderer's
// part and the whole step have their own benchmarks.

#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/image.h"
#include "core/parallel.h"
#include "core/random.h"
#include "splat/optim/adam.h"
#include "splat/optim/learning_rates.h"
#include "splat/optim/loss.h"
#include "splat/scene/gaussian_model.h"
#include "tests/random_image.h"

namespace freegs::splat {
namespace {

GaussianModel RandomModel(size_t count, int sh_degree, uint64_t seed) {
  GaussianModel model;
  model.sh_degree = sh_degree;
  model.Resize(count);
  for (const Parameter parameter : kAllParameters) {
    std::vector<float>& array = ParameterArray(model, parameter);
    for (size_t i = 0; i < array.size(); ++i) {
      array[i] = static_cast<float>(
          RandomUniform(seed, static_cast<uint64_t>(parameter), i) - 0.5);
    }
  }
  return model;
}

// Arguments: width, height, threads.
void BM_PhotometricLoss(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  const int height = static_cast<int>(state.range(1));
  ThreadPool pool(static_cast<int>(state.range(2)));
  const ImageF rendered = RandomImage(width, height, 3, 1);
  const ImageF target = RandomImage(width, height, 3, 2);
  PhotometricLoss loss;
  ImageF gradient;
  for (auto _ : state) {
    benchmark::DoNotOptimize(loss.Compute(rendered, target, pool, &gradient));
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<int64_t>(rendered.num_pixels()));
}
BENCHMARK(BM_PhotometricLoss)
    ->ArgNames({"width", "height", "threads"})
    ->Args({480, 270, 1})
    ->Args({480, 270, 2})
    ->Args({1600, 1200, 1})
    ->Args({1600, 1200, 2})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// Arguments: Gaussians, SH degree, share touched in percent, threads.
void BM_AdamStep(benchmark::State& state) {
  const auto count = static_cast<size_t>(state.range(0));
  const int degree = static_cast<int>(state.range(1));
  const double share = static_cast<double>(state.range(2)) / 100.0;
  ThreadPool pool(static_cast<int>(state.range(3)));
  GaussianModel model = RandomModel(count, degree, 1);
  const GaussianGradients gradients = RandomModel(count, degree, 2);
  std::vector<uint32_t> touched;
  for (size_t i = 0; i < count; ++i) {
    if (RandomUniform(3, 0, i) < share) {
      touched.push_back(static_cast<uint32_t>(i));
    }
  }
  Adam adam;
  adam.Reset(model);
  const LearningRates rates = LearningRatesAt({}, 1.0, 0);
  for (auto _ : state) {
    adam.Step(rates, gradients, touched, pool, &model);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<int64_t>(touched.size()));
}
BENCHMARK(BM_AdamStep)
    ->ArgNames({"gaussians", "degree", "touched", "threads"})
    ->Args({15000, 3, 100, 1})
    ->Args({15000, 3, 100, 2})
    ->Args({100000, 0, 100, 1})
    ->Args({100000, 3, 100, 1})
    ->Args({100000, 3, 100, 2})
    ->Args({100000, 3, 40, 1})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace freegs::splat
