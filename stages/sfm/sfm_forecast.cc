// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/sfm_forecast.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "sfm/mapping/confirm_poses.h"
#include "sfm/scene/model_io.h"

namespace freegs::stages {
namespace {

using pipeline::SceneOutlook;
using pipeline::StageNeed;

// The search for features doubles the sides of a picture. On each thread it
// holds six blurred pictures of that size and five differences of them, as
// floats, and a third as much again for the smaller octaves. Before, it holds
// the photo itself, as it is decoded and as RGB.
constexpr double kFeatureBytesPerPixel = 240;
constexpr double kPhotoBytesPerPixel = 6;

// Without sfm.max_image_size the side is chosen from 800 to 1600 by the number
// of features found. With this one the error is small at both ends.
constexpr int kUsualSide = 1250;

// Descriptors (128 bytes each) and the matches that a feature has in other
// photos, in the database, the mapper's graph and our own copy. A
// feature of bonsai's 292 photos took 620 bytes; longer tracks take more.
constexpr double kBytesPerFeature = 900;
constexpr double kDiskBytesPerFeature = 220;

// The more photos there are, the more of their features show the same points:
// the points grow with the square root of the number of photos. So many are
// found in scenes full of detail; most have two thirds of it.
constexpr double kPointsPerFeature = 0.61;

// CPU seconds with kUsualFeatures in each photo, for features, matches and what
// comes after; fitted on fox, tabletop, playroom and bonsai. The mapper adjusts
// all photos again and again, so a photo costs more the more there are. The
// exponent was chosen by runs of 60, 300 and 1000 photos. Of many photos it
// maps a part, of about kSkeletonShare, and each photo then costs a little more
// for its place and its points; this was chosen by bonsai and by 300 and 1000
// drawn photos.
constexpr double kUsualFeatures = 3000;
constexpr double kSecondsPerPhoto = 0.17;
constexpr double kSecondsPerMegapixel = 0.03;
constexpr double kSecondsPerPair = 0.03;
constexpr double kMappingSecondsPerPhoto = 0.28;  // With kUsualPhotos photos.
constexpr double kUsualPhotos = 60;
constexpr double kMappingExponent = 0.75;
constexpr double kSkeletonShare = 0.4;
constexpr double kPlacingSecondsPerPhoto = 0.08;
constexpr double kSerial = 0.4;

// What the undistorter needs for each thread: the photo and the one without
// distortion, each decoded and as it is written. Then what the models need that
// are read beside it, and how long it takes.
constexpr double kUndistorterMemory = 40e6;
constexpr double kUndistortionBytesPerPixel = 12;
constexpr double kModelMemory = 20e6;
constexpr double kModelBytesPerPhoto = 350e3;
constexpr double kUndistortionSecondsPerMegapixel = 0.09;
constexpr double kUndistortionSecondsPerPhoto = 0.04;
constexpr double kUndistortionSerial = 0.2;
// PNG files stay about as large; JPEG files are written with a high quality.
constexpr double kDiskBytesPerPixel = 0.6;
constexpr double kModelDiskBytesPerPhoto = 130e3;

// CPU seconds with kUsualFeatures in each photo, for what comes after the
// matching.
double MappingSeconds(const sfm::SfmOptions& options, int64_t photos) {
  const auto count = static_cast<double>(photos);
  const bool part = options.MayMapPart(photos);
  const double mapped = part ? kSkeletonShare * count : count;
  const double seconds = kMappingSecondsPerPhoto * mapped *
                             std::pow(mapped / kUsualPhotos, kMappingExponent) +
                         (part ? kPlacingSecondsPerPhoto * count : 0);
  // Few photos are mapped again, usually once.
  const bool again = options.camera_model == "auto" &&
                     photos <= static_cast<int64_t>(sfm::kMostPhotosToConfirm);
  return again ? 2 * seconds : seconds;
}

}  // namespace

int64_t ExpectedPairs(const sfm::PairSelectionOptions& options,
                      int64_t photos) {
  const int64_t all = photos * (photos - 1) / 2;
  if (options.matcher == "exhaustive" ||
      (options.matcher == "auto" && photos <= options.max_exhaustive)) {
    return all;
  }
  // Photos that are alike choose one another.
  return std::min(all, photos * (options.num_neighbours + options.overlap) / 2);
}

StageNeed SfmNeed(const sfm::SfmOptions& options,
                  int threads,
                  SceneOutlook* scene) {
  const int64_t photos = scene->photos();
  scene->points = 0;
  if (photos == 0) return {};
  const int side =
      options.max_image_size > 0 ? options.max_image_size : kUsualSide;
  const pipeline::ViewPixels pixels = CountPixels(*scene, side);
  const int features_of_photo = options.FeaturesOf(photos);
  const double features = static_cast<double>(features_of_photo * photos);
  scene->points = std::llround(kPointsPerFeature * features_of_photo *
                               std::sqrt(static_cast<double>(photos)));
  const double extraction =
      static_cast<double>(pipeline::kProgramMemory) +
      threads *
          std::max(kFeatureBytesPerPixel * static_cast<double>(pixels.largest),
                   kPhotoBytesPerPixel *
                       static_cast<double>(CountPixels(*scene, 0).largest));
  const double mapping = static_cast<double>(pipeline::kProgramMemory) +
                         kBytesPerFeature * features;
  const double share = features_of_photo / kUsualFeatures;
  const auto count = static_cast<double>(photos);
  const double seconds =
      kSecondsPerPhoto * count +
      kSecondsPerMegapixel * 1e-6 * static_cast<double>(pixels.total) +
      kSecondsPerPair * share * share *
          static_cast<double>(ExpectedPairs(options.pairs, photos)) +
      share * MappingSeconds(options, photos);
  return {.memory_bytes = std::llround(std::max(extraction, mapping)),
          .disk_bytes = std::llround(kDiskBytesPerFeature * features),
          .seconds = pipeline::OnThreads(seconds, kSerial, threads),
          .advice =
              "lower sfm.max_image_size, sfm.max_features or general.threads, "
              "or take fewer photos (ingest.keep_sharpest)"};
}

StageNeed UndistortNeed(const SceneOutlook& scene, int cores, int processors) {
  const auto photos = static_cast<double>(scene.photos());
  if (photos == 0) return {};
  const pipeline::ViewPixels pixels = CountPixels(scene, 0);
  const double undistorter =
      kUndistorterMemory + kUndistortionBytesPerPixel *
                               std::min<double>(processors, photos) *
                               static_cast<double>(pixels.largest);
  const double model = static_cast<double>(pipeline::kProgramMemory) +
                       kModelMemory + kModelBytesPerPhoto * photos;
  const double seconds = kUndistortionSecondsPerMegapixel * 1e-6 *
                             static_cast<double>(pixels.total) +
                         kUndistortionSecondsPerPhoto * photos;
  return {.memory_bytes = std::llround(std::max(undistorter, model)),
          .disk_bytes = std::llround(
              kModelDiskBytesPerPhoto * photos +
              std::max(static_cast<double>(scene.photo_bytes),
                       kDiskBytesPerPixel * static_cast<double>(pixels.total))),
          .seconds = pipeline::OnThreads(seconds, kUndistortionSerial, cores),
          .advice = "give smaller photos"};
}

void SetSceneToModel(const std::filesystem::path& folder, SceneOutlook* scene) {
  std::set<std::string> holdout;
  for (const View& view : scene->holdout) holdout.insert(view.name);
  scene->train.clear();
  scene->holdout.clear();
  scene->points = 0;
  const auto model = sfm::ReadModel(folder);
  if (!model.ok()) return;
  const auto cameras = sfm::IndexCameras(*model);
  for (const sfm::PosedImage& image : model->images) {
    const auto index = cameras.find(image.camera_id);
    if (index == cameras.end()) continue;
    const sfm::Camera& camera = model->cameras[index->second];
    View view;
    view.name = image.name;
    view.camera.width = static_cast<int>(camera.width);
    view.camera.height = static_cast<int>(camera.height);
    (holdout.contains(view.name) ? scene->holdout : scene->train)
        .push_back(std::move(view));
  }
  scene->points = static_cast<int64_t>(model->points3d.size());
}

}  // namespace freegs::stages
