// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_forecast.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/number_text.h"
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

// Semantic vectors have at most so many numbers, unless bootstrap.feature_dim
// asks for more; of scenes so far they had kUsualDim.
constexpr int kMaxChosenDim = 128;
constexpr int kUsualDim = 16;
// The longest features of a CLIP model. Vectors are not longer than these.
constexpr int kLongestFeature = 1024;

// A number of a longer vector is a float, with two copies while the vectors are
// written.
constexpr double kBytesPerLiftedNumber = 12;
// With mode paper each number also has a gradient and two moments. While a
// checkpoint is written, the number and its moments are there twice more: as a
// copy, and as the content of the file.
constexpr double kBytesPerTrainedNumber = (3 + 2 * 3) * 4;
constexpr double kDiskBytesPerTrainedNumber = 3 * 4;
// The features, the photo and the instances of a view that mode paper trains
// on.
constexpr double kBytesPerTrainingView = 1.5e6;

// Clustering in the union space lists bootstrap.min_samples neighbours of each
// Gaussian and the distance to the last one (semantics/hdbscan/core_distances).
constexpr double kBytesPerNeighbour = 4;

// What a network keeps between its layers, one copy of the network per thread.
constexpr double kNetworkBytesPerThread = 30e6;

// OpenCV copies the weights of a network when it loads it.
constexpr double kCopiesOfModel = 2.5;

// While a thread reads a photo: as decoded, and in the order RGB.
constexpr double kBytesPerPhotoPixel = 6;

// Lists of tiles, buffers of the threads, trees.
constexpr double kWorkMemory = 100e6;

constexpr double kSeconds = 1.7;
constexpr double kSecondsPerTeacher = 0.72;
constexpr double kSecondsPerTeacherMegapixel = 0.07;
constexpr double kSecondsPerMillion = 23;
constexpr double kSerial = 0.25;

// The map of instances of a photo: drawing the Gaussians, then filling and
// writing its pixels. All threads take part (stages/scene/instance_maps.cc).
// Measured on a drawn room with 24 000 and 188 000 Gaussians.
constexpr double kMapSeconds = 0.002;
constexpr double kMapSecondsPerMillion = 0.15;
constexpr double kMapSecondsPerMegapixel = 0.05;
constexpr double kMapSerial = 0.1;

// What mode paper takes. A step moves all numbers of all vectors. After each
// clustering the masks of all teachers are refined, at this longest side
// (semantics/field/instance_semantics.cc).
constexpr double kSecondsPerStep = 0.008;
constexpr double kSecondsPerStepAndNumber = 4e-9;
constexpr double kSecondsPerRefinedMegapixel = 6;
constexpr int kRefinedSide = 480;

// Features of the photos that teach, maps of instances in all photos, previews,
// and of each Gaussian a vector of the usual length and its place in the
// hierarchy.
constexpr double kDiskBytesPerTeacher = 200e3;
constexpr double kDiskBytesPerPixel = 0.03;
constexpr double kDiskBytesPerPreviewPixel = 0.5;
constexpr double kDiskBytesPerGaussian = 80;
constexpr double kDiskBytesPerNumber = 4;

// The numbers of a semantic vector, where the scene would choose `chosen`.
int VectorDim(const BootstrapStageOptions& options, int chosen) {
  const int asked = options.method.features.dim;
  return asked > 0 ? std::min(asked, kLongestFeature) : chosen;
}

// What training does at most.
struct TrainingCourse {
  int64_t steps = 0;
  int64_t clusterings = 0;  // With the one at the end.
};

TrainingCourse CourseOf(const BootstrapStageOptions& options) {
  const semantics::FieldTrainingOptions& training = options.method.training;
  TrainingCourse course{.steps = training.iterations, .clusterings = 1};
  const int64_t interval = std::max(training.cluster_interval, 1);
  if (training.cluster_start <= 0 || course.steps <= training.cluster_start) {
    return course;
  }
  const int64_t during =
      1 + (course.steps - 1 - training.cluster_start) / interval;
  // Clustering by evidence does not look at vectors, and neither does the union
  // space without semantics. Then the second clustering agrees with the first,
  // which ends the training.
  const bool looks_at_vectors =
      options.clustering == "union" &&
      options.method.clustering.union_space.space.with_semantics();
  if (!looks_at_vectors && training.settled_index <= 1 && during >= 2) {
    return {.steps = training.cluster_start + interval, .clusterings = 3};
  }
  course.clusterings += during;
  return course;
}

// The time of training on one thread.
double TrainingSeconds(const BootstrapStageOptions& options,
                       double gaussians,
                       std::span<const View> teachers) {
  const TrainingCourse course = CourseOf(options);
  const double step = kSecondsPerStep + kSecondsPerStepAndNumber * gaussians *
                                            VectorDim(options, kUsualDim);
  const auto refined =
      static_cast<double>(pipeline::CountPixels(teachers, kRefinedSide).total);
  return step * static_cast<double>(course.steps) +
         kSecondsPerRefinedMegapixel * 1e-6 * refined *
             static_cast<double>(course.clusterings);
}

// The time of the maps of all photos on one thread.
double MapSeconds(const pipeline::SceneOutlook& scene) {
  return static_cast<double>(scene.photos()) *
             (kMapSeconds + kMapSecondsPerMillion * 1e-6 *
                                static_cast<double>(scene.gaussians)) +
         kMapSecondsPerMegapixel * 1e-6 *
             static_cast<double>(CountPixels(scene, 0).total);
}

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
  const int dim = std::max(kMaxChosenDim, VectorDim(options, kMaxChosenDim));
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
  double seconds = kSeconds +
                   kSecondsPerTeacher * static_cast<double>(teachers.size()) +
                   kSecondsPerTeacherMegapixel * 1e-6 *
                       static_cast<double>(pixels(0).total) +
                   kSecondsPerMillion * 1e-6 * gaussians;
  if (options.mode != "geometry") {
    const int side = options.method.weights.max_side;
    const double weights =
        kWeightBytesPerPixel * static_cast<double>(pixels(side).total);
    const double kept =
        std::min(options.weights_memory_gb * double{kGigabyte}, weights);
    bytes += kept + kNetworkBytesPerThread * threads +
             kCopiesOfModel * static_cast<double>(model_bytes);
    disk +=
        std::min(weights - kept,
                 static_cast<double>(options.method.weights.max_scratch_bytes));
    bytes += kBytesPerLiftedNumber * (dim - kMaxChosenDim) * gaussians;
    disk += kDiskBytesPerNumber *
            std::max(0, VectorDim(options, kUsualDim) - kUsualDim) * gaussians;
  }
  if (options.clustering == "union") {
    const int neighbours =
        options.method.clustering.union_space.hdbscan.min_samples;
    bytes += kBytesPerNeighbour * (neighbours + 1.0) * gaussians;
  }
  if (options.mode == "paper") {
    const double trained = VectorDim(options, kMaxChosenDim) * gaussians;
    bytes += kBytesPerTrainedNumber * trained +
             kBytesPerTrainingView * static_cast<double>(teachers.size());
    disk += kDiskBytesPerTrainedNumber * trained;  // The checkpoint.
    seconds += TrainingSeconds(options, gaussians, teachers);
  }
  return {
      .memory_bytes = pipeline::kProgramMemory + std::llround(bytes),
      .disk_bytes = std::llround(disk),
      .seconds = pipeline::OnThreads(seconds, kSerial, threads) +
                 pipeline::OnThreads(MapSeconds(scene), kMapSerial, threads),
      .advice =
          "lower bootstrap.weights_memory_gb, general.threads or the "
          "number of Gaussians (reconstruct.budget)"};
}

}  // namespace freegs::stages
