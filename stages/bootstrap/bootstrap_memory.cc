// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_memory.h"

#include <algorithm>
#include <cmath>

#include "pipeline/stage.h"

namespace freegs::stages {
namespace {

// About 32 Gaussians blend into a pixel; each weight takes 8 bytes
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

// While a photo is read and reduced: as decoded, and in the order RGB.
constexpr double kBytesPerPhotoPixel = 6;

}  // namespace

int64_t BootstrapMemory(const BootstrapStageOptions& options,
                        const BootstrapSize& size) {
  double bytes = kWeightBytesPerPixel * static_cast<double>(size.patch_pixels) +
                 kBytesPerPhotoPixel * static_cast<double>(size.photo_pixels) +
                 kBytesPerGaussian * static_cast<double>(size.gaussians);
  if (options.mode != "geometry") {
    bytes += std::min(
        options.weights_memory_gb * (1 << 30),
        kWeightBytesPerPixel * static_cast<double>(size.weight_pixels));
    bytes += kNetworkBytesPerThread * size.threads +
             kCopiesOfModel * static_cast<double>(size.model_bytes);
  }
  if (options.mode == "paper") {
    bytes += kTrainedBytesPerGaussian * static_cast<double>(size.gaussians);
  }
  return pipeline::kProgramMemory + std::llround(bytes);
}

}  // namespace freegs::stages
