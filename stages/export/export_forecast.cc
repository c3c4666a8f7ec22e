// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/export_forecast.h"

#include <algorithm>
#include <cmath>

namespace freegs::stages {
namespace {

// Lists of tiles, buffers of the threads, the page.
constexpr double kWorkMemory = 45e6;

// Bytes for each pixel of a view that is drawn: colour (3 floats),
// transmittance, depth and label (4 bytes each); the pictures made of it come
// after some of these are gone.
constexpr double kBytesPerPixel = 18;

// The model as it is, and as it is moved, coloured, sorted and written.
constexpr double kBytesPerGaussian = 1400;

constexpr double kSeconds = 0.6;
constexpr double kSecondsPerMegapixel = 0.15;  // For the views that are drawn.
constexpr double kSecondsPerMillion = 7;
constexpr double kSerial = 0.5;

// Two PLY files, a .splat, an .spz, and the scene of the page's 3D view.
constexpr double kDiskBytesPerGaussian = 420;
constexpr double kDiskBytesOfPage = 4e6;
// Pictures of the report, and masks.
constexpr double kDiskBytesPerPixel = 0.5;

}  // namespace

pipeline::StageNeed ExportNeed(const ExportStageOptions& options,
                               int threads,
                               const pipeline::SceneOutlook& scene) {
  if (scene.photos() == 0 || scene.gaussians <= 0) return {};
  const auto gaussians = static_cast<double>(scene.gaussians);
  const pipeline::ViewPixels pixels = CountPixels(scene, 0);
  const auto holdout = static_cast<double>(scene.holdout.size());
  const double views =
      holdout +
      std::min(static_cast<double>(options.mask_views),
               static_cast<double>(scene.train.size())) +
      std::min(static_cast<double>(options.report_views),
               holdout > 0 ? holdout : static_cast<double>(scene.train.size()));
  const double drawn = views * static_cast<double>(pixels.total) /
                       static_cast<double>(scene.photos());
  const double seconds = kSeconds + kSecondsPerMegapixel * 1e-6 * drawn +
                         kSecondsPerMillion * 1e-6 * gaussians;
  return {
      .memory_bytes =
          pipeline::kProgramMemory +
          std::llround(kWorkMemory +
                       kBytesPerPixel * static_cast<double>(pixels.largest) +
                       kBytesPerGaussian * gaussians),
      .disk_bytes = std::llround(kDiskBytesOfPage + kDiskBytesPerPixel * drawn +
                                 kDiskBytesPerGaussian * gaussians),
      .seconds = pipeline::OnThreads(seconds, kSerial, threads),
      .advice =
          "lower undistort.max_image_size or the number of Gaussians "
          "(reconstruct.budget)"};
}

}  // namespace freegs::stages
