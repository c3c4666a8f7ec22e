// SPDX-License-Identifier: BSD-3-Clause
// One step of learning the semantic field, part by part: the decoder there and
// back, and the losses, on random numbers.

#include <vector>

#include <benchmark/benchmark.h>

#include "core/random.h"
#include "semantics/losses/decoder_training.h"
#include "semantics/losses/joint_contrastive_loss.h"
#include "semantics/losses/pixel_distillation_loss.h"
#include "semantics/losses/smoothing_loss.h"

namespace freegs::semantics {
namespace {

constexpr int kChannels = 512;
constexpr int kGroups = 40;

std::vector<float> RandomValues(size_t count, uint64_t seed) {
  std::vector<float> values(count);
  for (size_t k = 0; k < count; ++k) {
    values[k] = static_cast<float>(RandomUniform(seed, 0, k)) - 0.5f;
  }
  return values;
}

std::vector<int32_t> RandomGroups(size_t count, uint64_t seed) {
  std::vector<int32_t> groups(count);
  for (size_t k = 0; k < count; ++k) {
    groups[k] = static_cast<int32_t>(RandomIndex(seed, 0, k, kGroups));
  }
  return groups;
}

void Expect(const Status& status, benchmark::State& state) {
  if (!status.ok()) state.SkipWithError(status.message().c_str());
}

void BM_DecoderStep(benchmark::State& state) {
  const auto rows = static_cast<size_t>(state.range(0));
  const auto dim = static_cast<int>(state.range(1));
  ThreadPool pool(static_cast<int>(state.range(2)));
  FeatureDecoder decoder(RandomMlpDecoder({.latent_dim = dim}, 1));
  DecoderTraining training({}, &decoder);
  const std::vector<float> latents = RandomValues(rows * dim, 1);
  const std::vector<float> gradients = RandomValues(rows * kChannels, 2);
  std::vector<float> latent_gradients(latents.size(), 0.0f);
  for (auto _ : state) {
    Expect(training.Forward(latents, pool).status(), state);
    Expect(training.Backward(gradients, pool, latent_gradients), state);
    Expect(training.Step(pool), state);
  }
  const MlpShape& shape = decoder.mlp()->shape;
  const double products = static_cast<double>(rows) * shape.hidden_dim *
                          (shape.latent_dim + shape.feature_dim);
  state.counters["GFLOP/s"] = benchmark::Counter(
      3 * 2e-9 * products,  // There, and back to weights and to inputs.
      benchmark::Counter::kIsIterationInvariantRate);
}

void BM_Decode(benchmark::State& state) {
  const auto rows = static_cast<size_t>(state.range(0));
  const auto dim = static_cast<int>(state.range(1));
  ThreadPool pool(static_cast<int>(state.range(2)));
  const FeatureDecoder decoder(RandomMlpDecoder({.latent_dim = dim}, 1));
  const std::vector<float> latents = RandomValues(rows * dim, 1);
  std::vector<float> features(rows * kChannels);
  for (auto _ : state) Expect(decoder.Decode(latents, pool, features), state);
}

void BM_PixelDistillationLoss(benchmark::State& state) {
  const auto rows = static_cast<size_t>(state.range(0));
  ThreadPool pool(static_cast<int>(state.range(1)));
  const std::vector<float> decoded = RandomValues(rows * kChannels, 1);
  const std::vector<float> targets = RandomValues(rows * kChannels, 2);
  std::vector<float> gradients(decoded.size(), 0.0f);
  for (auto _ : state) {
    Expect(
        PixelDistillationLoss(decoded, targets, kChannels, 1.0, pool, gradients)
            .status(),
        state);
  }
}

void BM_BuildNeighborTable(benchmark::State& state) {
  const auto count = static_cast<size_t>(state.range(0));
  ThreadPool pool(static_cast<int>(state.range(1)));
  const std::vector<float> positions = RandomValues(3 * count, 1);
  for (auto _ : state) {
    Expect(BuildNeighborTable(positions, 5, pool).status(), state);
  }
}

// Times the loss with 0.1 % of the Gaussians as samples.
void BM_SmoothingLoss(benchmark::State& state) {
  const auto count = static_cast<size_t>(state.range(0));
  const auto dim = static_cast<int>(state.range(1));
  ThreadPool pool(static_cast<int>(state.range(2)));
  const NeighborTable table =
      *BuildNeighborTable(RandomValues(3 * count, 1), 5, pool);
  const std::vector<float> features = RandomValues(count * dim, 2);
  std::vector<float> gradients(features.size(), 0.0f);
  uint64_t step = 0;
  for (auto _ : state) {
    const std::vector<uint32_t> samples =
        SampleForSmoothing({}, count, 1, ++step);
    Expect(SmoothingLoss(features, dim, table, samples, 0.1, pool, gradients)
               .status(),
           state);
  }
}

// All Gaussians and 2048 pixels, in 40 groups.
void BM_JointContrastiveLoss(benchmark::State& state) {
  constexpr size_t kPixels = 2048;
  const auto count = static_cast<size_t>(state.range(0));
  const auto dim = static_cast<int>(state.range(1));
  ThreadPool pool(static_cast<int>(state.range(2)));
  const std::vector<float> gaussians = RandomValues(count * dim, 1);
  const std::vector<float> pixels = RandomValues(kPixels * dim, 2);
  const std::vector<int32_t> gaussian_groups = RandomGroups(count, 3);
  const std::vector<int32_t> pixel_groups = RandomGroups(kPixels, 4);
  std::vector<float> gaussian_gradients(gaussians.size(), 0.0f);
  std::vector<float> pixel_gradients(pixels.size(), 0.0f);
  for (auto _ : state) {
    Expect(
        JointContrastiveLoss({},
                             dim,
                             {gaussians, gaussian_groups, gaussian_gradients},
                             {pixels, pixel_groups, pixel_gradients},
                             0.05,
                             pool)
            .status(),
        state);
  }
}

void Arguments(benchmark::internal::Benchmark* b) {
  b->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK(BM_DecoderStep)
    ->Apply(Arguments)
    ->ArgNames({"rows", "dim", "threads"})
    ->ArgsProduct({{512, 1024, 2048}, {16, 32, 128}, {1, 2}});
BENCHMARK(BM_Decode)
    ->Apply(Arguments)
    ->ArgNames({"rows", "dim", "threads"})
    ->ArgsProduct({{50000}, {16, 128}, {1, 2}});
BENCHMARK(BM_PixelDistillationLoss)
    ->Apply(Arguments)
    ->ArgNames({"rows", "threads"})
    ->ArgsProduct({{1024}, {1, 2}});
BENCHMARK(BM_BuildNeighborTable)
    ->Apply(Arguments)
    ->ArgNames({"gaussians", "threads"})
    ->ArgsProduct({{50000}, {1, 2}});
BENCHMARK(BM_SmoothingLoss)
    ->Apply(Arguments)
    ->ArgNames({"gaussians", "dim", "threads"})
    ->ArgsProduct({{50000}, {16, 128}, {1, 2}});
BENCHMARK(BM_JointContrastiveLoss)
    ->Apply(Arguments)
    ->ArgNames({"gaussians", "dim", "threads"})
    ->ArgsProduct({{50000}, {16, 128}, {1, 2}});

}  // namespace
}  // namespace freegs::semantics
