// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_forecast.h"

#include <algorithm>
#include <cmath>

#include "semantics/geometry/view_choice.h"
#include "semantics/patches/scene_patches.h"

namespace freegs::stages {
namespace {

// About 32 Gaussians blend into a pixel; each weight takes 8 bytes, and twice
// as many while the weights of a view are computed
// (splat/weights/blending_weights.h).
constexpr double kWeightBytesPerPixel = 32 * 8;

// The model, what is known of each Gaussian while patches are made, trees of
// neighbours, and a semantic vector of up to 128 floats.
constexpr double kBytesPerGaussian = 1500;

// With mode paper semantic vectors of 128 floats have gradients and moments.
constexpr double kTrainedBytesPerGaussian = 3 * 128 * 4;

// What a network keeps between its layers, one copy of the network per thread.
constexpr double kNetworkBytesPerThread = 30e6;

// OpenCV copies the weights of a network when it loads it.
constexpr double kCopiesOfModel = 2.5;

// While a thread reads a photo: as decoded, and in the order RGB.
constexpr double kBytesPerPhotoPixel = 6;

// Lists of tiles, buffers of the threads, trees.
constexpr double kWorkMemory = 100e6;

constexpr double kSeconds = 6.5;
constexpr double kSecondsPerPhotoMegapixel = 3.7;
constexpr double kSecondsPerMillion = 31;
constexpr double kSerial = 0.43;
constexpr double kSecondsPerTrainingStep = 0.008;

// Features of the photos that teach, maps of instances in all photos, previews,
// and of each Gaussian a vector and its place in the hierarchy.
constexpr double kDiskBytesPerTeacher = 200e3;
constexpr double kDiskBytesPerPixel = 0.03;
constexpr double kDiskBytesPerPreviewPixel = 0.5;
constexpr double kDiskBytesPerGaussian = 80;

}  // namespace

std::vector<View> Teachers(const BootstrapStageOptions& options,
                           const std::vector<View>& train) {
  if (options.mode == "paper") return train;
  std::vector<View> chosen;
  for (const size_t view :
       semantics::ChooseViews(train.size(), kMaxLiftedViews)) {
    chosen.push_back(train[view]);
  }
  return chosen;
}

pipeline::StageNeed BootstrapNeed(const BootstrapStageOptions& options,
                                  int64_t model_bytes,
                                  int threads,
                                  const pipeline::SceneOutlook& scene) {
  if (scene.train.empty() || scene.gaussians <= 0) return {};
  const std::vector<View> teachers = Teachers(options, scene.train);
  const auto pixels = [&](int side) {
    return pipeline::CountPixels(teachers, side);
  };
  const auto gaussians = static_cast<double>(scene.gaussians);
  const auto photo_pixels = static_cast<double>(pixels(0).largest);
  const auto patch_pixels =
      static_cast<double>(pixels(semantics::kPatchImageSide).largest);
  double bytes = kWorkMemory + 2 * kWeightBytesPerPixel * patch_pixels +
                 kBytesPerPhotoPixel * photo_pixels * threads +
                 kBytesPerGaussian * gaussians;
  double disk =
      kDiskBytesPerTeacher * static_cast<double>(teachers.size()) +
      kDiskBytesPerPixel * static_cast<double>(CountPixels(scene, 0).total) +
      kDiskBytesPerPreviewPixel * photo_pixels * options.num_previews +
      kDiskBytesPerGaussian * gaussians;
  double seconds = kSeconds + kSecondsPerPhotoMegapixel * 1e-6 * photo_pixels +
                   kSecondsPerMillion * 1e-6 * gaussians;
  if (options.mode != "geometry") {
    const int side = options.method.weights.max_side;
    const double weights =
        kWeightBytesPerPixel * static_cast<double>(pixels(side).total);
    const double kept =
        std::min(options.weights_memory_gb * (1 << 30), weights);
    bytes += kept + kNetworkBytesPerThread * threads +
             kCopiesOfModel * static_cast<double>(model_bytes);
    disk += weights - kept;
  }
  if (options.mode == "paper") {
    bytes += kTrainedBytesPerGaussian * gaussians;
    disk += kTrainedBytesPerGaussian * gaussians;  // The checkpoint.
    seconds += kSecondsPerTrainingStep * options.method.training.iterations;
  }
  return {.memory_bytes = pipeline::kProgramMemory + std::llround(bytes),
          .disk_bytes = std::llround(disk),
          .seconds = pipeline::OnThreads(seconds, kSerial, threads),
          .advice =
              "lower bootstrap.weights_memory_gb, general.threads or the "
              "number of Gaussians (reconstruct.budget)"};
}

}  // namespace freegs::stages
