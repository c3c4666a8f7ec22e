// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_memory.h"

#include <algorithm>
#include <cmath>

#include "pipeline/stage.h"
#include "stages/scene/scene_size.h"

namespace freegs::stages {
namespace {

// A photo is kept as 8-bit RGB, its mask as one more byte. The smaller levels
// of its pyramid add a third (holdout photos have two such levels: five
// sixteenths).
constexpr double kLevelsOfTrainPhoto = 4 / 3.0;
constexpr double kLevelsOfHoldoutPhoto = 21 / 16.0;

// While it is read, a photo is there twice: as decoded, and in the order RGB.
constexpr double kBytesPerDecodedPixel = 6;

// Of the view that a step renders, in floats: colour, photo and gradient (3
// each), three maps of SSIM's derivatives (3 each), transmittance, and which
// Gaussian is the dominant one.
constexpr double kBytesPerViewPixel = 4 * (3 * 3 + 3 * 3 + 2);

// Copies of a Gaussian's parameters. Training has four: the model, two moments
// and the last good state; checkpoints are written from them. The lists of what
// a view shows add about as much as two more, and while Gaussians are chosen or
// sorted there is one more of some arrays.
constexpr double kCopiesOfGaussian = 4 + 2 + 1;

// A densification makes about four new Gaussians of ten.
constexpr double kGrowth = 1.4;

// Of an automatic budget's dense model, which only few scenes fill. To expect
// too much does less harm than to expect too little.
constexpr double kUsualShare = 0.8;

double Densifications(const splat::ScheduleOptions& schedule) {
  if (schedule.densify_interval <= 0) return 0;
  const bool mini =
      schedule.method == splat::DensificationMethod::kMiniSplatting;
  const double share = mini ? schedule.simplify_at - schedule.mini_densify_start
                            : schedule.densify_stop - schedule.densify_start;
  return std::floor(share * schedule.iterations / schedule.densify_interval);
}

}  // namespace

std::optional<double> ExpectedGaussians(const ReconstructStageOptions& options,
                                        const splat::TrainerOptions& training,
                                        const ReconstructSize& size) {
  const splat::ScheduleOptions& schedule = training.schedule;
  const auto points = static_cast<double>(size.points);
  if (schedule.method == splat::DensificationMethod::kNone) return points;
  if (training.budget <= 0) return std::nullopt;
  auto most = static_cast<double>(training.budget);
  if (schedule.method == splat::DensificationMethod::kMiniSplatting) {
    most *= training.mini_splatting.dense_factor;
    if (options.budget == "auto") most *= kUsualShare;
  }
  const double grown = points * std::pow(kGrowth, Densifications(schedule));
  return std::max(points, std::min(most, grown));
}

int64_t ReconstructMemory(const ReconstructStageOptions& options,
                          const splat::TrainerOptions& training,
                          const ReconstructSize& size) {
  const double reading = kBytesPerDecodedPixel * size.threads *
                         static_cast<double>(size.photo_pixels);
  const double bytes_per_pixel = size.masks ? 4 : 3;
  double images = kLevelsOfHoldoutPhoto * bytes_per_pixel *
                  static_cast<double>(size.holdout_pixels);
  double work = kBytesPerViewPixel * static_cast<double>(size.view_pixels);
  if (!options.import.empty()) {
    work +=
        static_cast<double>(kBytesPerReadGaussian * size.imported_gaussians);
  } else {
    const std::optional<double> gaussians =
        ExpectedGaussians(options, training, size);
    if (!gaussians) return 0;
    const int coefficients =
        splat::NumShCoefficients(training.schedule.sh_degree);
    const double parameters = 11 + 3 * coefficients;
    work += *gaussians * kCopiesOfGaussian * parameters * sizeof(float);
    images += std::min(options.image_cache_gb * 1e9,
                       kLevelsOfTrainPhoto * bytes_per_pixel *
                           static_cast<double>(size.train_pixels));
  }
  return pipeline::kProgramMemory +
         std::llround(images + std::max(reading, work));
}

}  // namespace freegs::stages
