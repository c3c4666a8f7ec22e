// SPDX-License-Identifier: BSD-3-Clause
// Forward times of a CLIP model, and of what goes with them.
//
//   freegs_clip_benchmark [Google Benchmark's options]
//
// FREEGS_CLIP_MODEL names the model folder; models/small_clip without it. Real
// time: the networks use OpenCV's threads.

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "core/image.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "core/random.h"
#include "semantics/clip/feature_cache.h"
#include "semantics/clip/joint_bilateral_upsampling.h"
#include "semantics/clip/opencv_clip.h"

namespace freegs::semantics {
namespace {

std::unique_ptr<OpenCvClip> OpenModel(benchmark::State& state) {
  const char* named = std::getenv("FREEGS_CLIP_MODEL");
  auto clip = OpenCvClip::Open(named != nullptr ? named : FREEGS_SMALL_CLIP);
  if (clip.ok()) return *std::move(clip);
  state.SkipWithError(clip.status().message().c_str());
  return nullptr;
}

ImageU8 Noise(int width, int height) {
  ImageU8 image(width, height, 3);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<uint8_t>(255 * RandomUniform(1, 1, i));
  }
  return image;
}

// One call before the clock runs: networks are loaded at first use.
template <typename Call>
void Time(benchmark::State& state, Call call) {
  if (!call()) return state.SkipWithError("the model does not run");
  for (auto _ : state) benchmark::DoNotOptimize(call());
}

void BM_EncodeImage(benchmark::State& state) {
  const auto clip = OpenModel(state);
  if (clip == nullptr) return;
  const ImageU8 image = Noise(640, 480);
  Time(state, [&] { return clip->EncodeImage(image).ok(); });
}
BENCHMARK(BM_EncodeImage)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_EncodeText(benchmark::State& state) {
  const auto clip = OpenModel(state);
  if (clip == nullptr) return;
  Time(state, [&] { return clip->EncodeText("a photo of a red apple").ok(); });
}
BENCHMARK(BM_EncodeText)->UseRealTime()->Unit(benchmark::kMillisecond);

// Argument: which of the model's dense sizes.
void BM_EncodeDense(benchmark::State& state) {
  const auto clip = OpenModel(state);
  if (clip == nullptr) return;
  const std::vector<int> sizes = clip->dense_sizes();
  const auto which = static_cast<size_t>(state.range(0));
  if (which >= sizes.size()) {
    return state.SkipWithError("the model has fewer dense networks");
  }
  state.SetLabel(std::to_string(sizes[which]) + " pixels");
  const ImageU8 image = Noise(640, 480);
  Time(state, [&] { return clip->EncodeDense(image, sizes[which]).ok(); });
}
BENCHMARK(BM_EncodeDense)
    ->DenseRange(0, 5)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Arguments: the grid's side, threads. To 224 x 224, 512 channels.
void BM_Upsample(benchmark::State& state) {
  const auto grid = static_cast<int>(state.range(0));
  ThreadPool pool(static_cast<int>(state.range(1)));
  const ImageF features(grid, grid, 512, 0.5f);
  const ImageF guide = ToFloat(Noise(224, 224));
  Time(state,
       [&] { return JointBilateralUpsample(features, guide, {}, pool).ok(); });
}
BENCHMARK(BM_Upsample)
    ->ArgsProduct({{14, 28}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// What a view costs that was seen before.
void BM_FeatureCacheHit(benchmark::State& state) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "freegs_clip_benchmark";
  const FeatureCache cache(folder);
  if (!cache.Store("image", "model", "dense", ImageF(14, 14, 512, 0.5f)).ok()) {
    return state.SkipWithError("the cache cannot be written");
  }
  Time(state, [&] {
    return cache.Find("image", "model", "dense").features.has_value();
  });
  std::filesystem::remove_all(folder);
}
BENCHMARK(BM_FeatureCacheHit)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace freegs::semantics
