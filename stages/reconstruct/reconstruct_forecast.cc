// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_forecast.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/number_text.h"
#include "splat/density/mini_splatting.h"
#include "splat/search/exposure_search.h"
#include "stages/scene/scene_size.h"

namespace freegs::stages {
namespace {

using pipeline::StageNeed;

// A photo is kept as 8-bit RGB, its mask as one more byte. The smaller levels
// of the pyramid of a photo that is trained on add a third.
constexpr double kLevelsOfTrainPhoto = 4 / 3.0;

// What the scene shows of the holdout photos, as 8-bit RGB, is kept until all
// are measured.
constexpr double kBytesPerPicturePixel = 3;

// While it is read, a photo is there twice: as decoded, and in the order RGB.
constexpr double kBytesPerDecodedPixel = 6;

// Bytes of a photo with 3000 features while the sparse model is read: the model
// and the content of its files. It is let go before photos are read.
constexpr double kSparseBytesPerPhoto = 210e3;

// What a step keeps for each pixel of the view that it renders, in floats:
// colour, photo and gradient (3 each), three maps of SSIM's derivatives (3
// each), transmittance, and which Gaussian is the dominant one.
constexpr double kBytesPerViewPixel = 4 * (3 * 3 + 3 * 3 + 2);

// What training needs besides what follows: lists of tiles, buffers of the
// threads, pages that the allocator keeps.
constexpr double kWorkMemory = 180e6;

// Copies of a Gaussian's parameters. Training has four: the model, two moments
// and the last good state; checkpoints are written from them. The lists of what
// a view shows add the rest.
constexpr double kCopiesOfGaussian = 5.95;

// A densification makes about four new Gaussians of ten. Of seven scenes the
// dense models had 6 to 33 for each point, and 19 to 33 % of them were left at
// the end. To expect too much does less harm than to expect too little.
constexpr double kGrowth = 1.4;
constexpr double kGaussiansPerPoint = 30;
constexpr double kLeft = 0.31;

// Seconds of a step on one thread: for itself, for each megapixel and for each
// million Gaussians of SH degree 2; and the share of it that threads do not
// divide. Of 21 trainings of three scenes with the presets, whose seconds were
// known, these give 0.9 to 1.3 times the seconds.
constexpr double kStepSeconds = 0.02;
constexpr double kStepSecondsPerMegapixel = 0.06;
constexpr double kStepSecondsPerMillion = 0.16;
constexpr double kUsualParameters = (11 + 3 * 9) * sizeof(float);
constexpr double kSerial = 0.14;

// In a densification the number of Gaussians grows by about so many times the
// number of points, until there are as many as may be.
constexpr double kGrowthInPoints = 1.5;

// Between simplification and pruning there are more Gaussians than at the end:
// on the mean so many times as many, from the simplification on.
constexpr double kLeftUntilPruning = 1.15;

// Decoding a photo at its own size and reducing it. All photos are read on all
// threads before the training, and one by one those that a step needs again.
constexpr double kReadingSecondsPerMegapixel = 0.035;
constexpr double kReadingSerial = 0.1;

// Two checkpoints are kept, and a third is written before the oldest is
// removed. Each has the model, two moments, the last good state and three
// numbers of 4 bytes per Gaussian. In the last tenth of the steps, by when
// Mini-Splatting has cut the model down, it also has the mean.
constexpr double kCheckpoints = 3;
constexpr double kCopiesInCheckpoint = 4;
constexpr double kCountedBytes = 3 * 4;

// Size of the pictures of the holdout views.
constexpr double kDiskBytesPerPixel = 1;

double Densifications(const splat::ScheduleOptions& schedule) {
  if (schedule.densify_interval <= 0) return 0;
  const bool mini =
      schedule.method == splat::DensificationMethod::kMiniSplatting;
  const double share = mini ? schedule.simplify_at - schedule.mini_densify_start
                            : schedule.densify_stop - schedule.densify_start;
  return std::floor(share * schedule.iterations / schedule.densify_interval);
}

// The number of Gaussians on the mean of all steps.
double MeanGaussians(const splat::ScheduleOptions& schedule,
                     double points,
                     const ExpectedGaussians& gaussians) {
  const double densifications = Densifications(schedule);
  const bool mini =
      schedule.method == splat::DensificationMethod::kMiniSplatting;
  const double grown = gaussians.dense - points;
  double mean = gaussians.dense;
  if (grown > 0 && densifications > 0) {
    const double growing =
        std::min(1.0, grown / (kGrowthInPoints * points * densifications));
    mean -= growing * grown / 2;
  }
  const double until = mini ? schedule.simplify_at : schedule.densify_stop;
  const double left =
      mini ? kLeftUntilPruning * gaussians.left : gaussians.left;
  return until * mean + (1 - until) * left;
}

// How many photos training reads again, if the share `kept` of all stays in
// memory. Each time around it fetches them in another order, and the cache
// drops those that were not used for longest. Then the chance that a photo is
// still there is kept + (1 - kept) * log(1 - kept).
double PhotosReadAgain(const ReconstructStageOptions& options,
                       const splat::ScheduleOptions& schedule,
                       double photos,
                       double kept) {
  if (kept >= 1) return 0;
  double fetched = schedule.iterations;
  if (options.exposure == "auto") {
    const splat::ExposureSearchOptions search;
    fetched +=
        std::max(search.trial_share * schedule.iterations,
                 std::min<double>(search.min_trial_steps, schedule.iterations));
    fetched += 2 * photos;  // What the trial shows is measured.
  }
  if (schedule.method == splat::DensificationMethod::kMiniSplatting) {
    fetched += static_cast<double>(schedule.depth_reinit_at.size()) * photos;
  }
  return fetched * (1 - kept) * (1 - std::log(1 - kept));
}

// Seconds for reading all photos before the training, and for reading again
// those that memory does not keep. `kept` is the share of the photos that it
// keeps.
double ReadingSeconds(const ReconstructStageOptions& options,
                      const splat::ScheduleOptions& schedule,
                      double kept,
                      int threads,
                      const pipeline::SceneOutlook& scene) {
  const auto seconds_of = [](std::span<const View> views) {
    return kReadingSecondsPerMegapixel * 1e-6 *
           static_cast<double>(pipeline::CountPixels(views, 0).total);
  };
  const double holdout = seconds_of(scene.holdout);
  if (!options.import.empty()) {
    return pipeline::OnThreads(holdout, kReadingSerial, threads);
  }
  const double train = seconds_of(scene.train);
  const auto photos = static_cast<double>(scene.train.size());
  return pipeline::OnThreads(train + holdout, kReadingSerial, threads) +
         train / photos * PhotosReadAgain(options, schedule, photos, kept);
}

}  // namespace

ExpectedGaussians ExpectGaussians(const splat::TrainerOptions& training,
                                  int64_t points,
                                  int64_t train_pixels) {
  const splat::ScheduleOptions& schedule = training.schedule;
  const auto first = static_cast<double>(points);
  if (schedule.method == splat::DensificationMethod::kNone) {
    return {first, first};
  }
  const bool mini =
      schedule.method == splat::DensificationMethod::kMiniSplatting;
  double dense = std::min(kGaussiansPerPoint * first,
                          first * std::pow(kGrowth, Densifications(schedule)));
  if (mini && !schedule.depth_reinit_at.empty()) {
    const size_t drawn =
        splat::NumDepthPoints(training.mini_splatting,
                              training.budget,
                              static_cast<size_t>(dense),
                              static_cast<uint64_t>(train_pixels));
    dense = std::max(dense, static_cast<double>(drawn));
  }
  double left = mini ? kLeft * dense : dense;
  if (training.budget > 0) {
    const auto budget = static_cast<double>(training.budget);
    const double most =
        mini ? budget * training.mini_splatting.dense_factor : budget;
    dense = std::max(first, std::min(dense, most));
    left = std::min(left, budget);
    if (!mini) left = std::max(first, left);  // Initial points stay.
  }
  return {dense, left};
}

double HoldoutShareOfCache(int64_t train_pixels, int64_t holdout_pixels) {
  const auto holdout = static_cast<double>(holdout_pixels);
  return holdout /
         (holdout + kLevelsOfTrainPhoto * static_cast<double>(train_pixels));
}

StageNeed ReconstructNeed(const ReconstructStageOptions& options,
                          const splat::TrainerOptions& training,
                          int threads,
                          pipeline::SceneOutlook* scene) {
  const bool imported = !options.import.empty();
  if (!imported) scene->gaussians = 0;
  if (scene->train.empty() ||
      (imported ? scene->gaussians : scene->points) <= 0) {
    return {};
  }
  const int side = options.max_image_size;
  const auto train = pipeline::CountPixels(scene->train, side);
  const auto holdout = pipeline::CountPixels(scene->holdout, side);
  const double bytes_per_pixel = scene->masks ? 4 : 3;
  const double reading = kBytesPerDecodedPixel * threads *
                         static_cast<double>(CountPixels(*scene, 0).largest);
  const auto holdout_pixels = static_cast<double>(holdout.total);
  const double all_photos =
      bytes_per_pixel *
      (holdout_pixels + kLevelsOfTrainPhoto * static_cast<double>(train.total));
  const double photos =
      std::min(options.image_cache_gb * double{kGigabyte}, all_photos);
  const double holdout_share = HoldoutShareOfCache(train.total, holdout.total);
  // Pictures are made when the photos that were trained on are let go.
  double images = kBytesPerPicturePixel * holdout_pixels;
  double work = kBytesPerViewPixel *
                static_cast<double>(std::max(train.largest, holdout.largest));
  const int coefficients =
      splat::NumShCoefficients(training.schedule.sh_degree);
  const double parameters = (11 + 3 * coefficients) * sizeof(float);
  double seconds = 0;
  double checkpoints = 0;
  if (imported) {
    work += static_cast<double>(kBytesPerReadGaussian * scene->gaussians);
  } else {
    const ExpectedGaussians gaussians =
        ExpectGaussians(training, scene->points, train.total);
    scene->gaussians = std::llround(gaussians.left);
    work += kWorkMemory + gaussians.dense * kCopiesOfGaussian * parameters;
    images = std::max(images, (1 - holdout_share) * photos);
    const double megapixels = 1e-6 * static_cast<double>(train.total) /
                              static_cast<double>(scene->train.size());
    const double mean = MeanGaussians(
        training.schedule, static_cast<double>(scene->points), gaussians);
    seconds =
        options.iterations *
        (kStepSeconds + kStepSecondsPerMegapixel * megapixels +
         kStepSecondsPerMillion * 1e-6 * mean * parameters / kUsualParameters);
    const auto checkpoint = [&](double count, double copies) {
      return count * (copies * parameters + kCountedBytes);
    };
    checkpoints = kCheckpoints *
                  std::max(checkpoint(gaussians.dense, kCopiesInCheckpoint),
                           checkpoint(gaussians.left, kCopiesInCheckpoint + 1));
  }
  images += holdout_share * photos;
  const double sparse =
      kSparseBytesPerPhoto * static_cast<double>(scene->photos());
  return {
      .memory_bytes =
          pipeline::kProgramMemory +
          std::llround(std::max(sparse, images + std::max(reading, work))),
      .disk_bytes =
          std::llround(static_cast<double>(scene->gaussians) * parameters +
                       checkpoints + kDiskBytesPerPixel * holdout_pixels),
      .seconds =
          pipeline::OnThreads(seconds, kSerial, threads) +
          ReadingSeconds(
              options, training.schedule, photos / all_photos, threads, *scene),
      .advice =
          "lower reconstruct.budget, reconstruct.max_image_size, "
          "reconstruct.image_cache_gb or general.threads"};
}

}  // namespace freegs::stages
