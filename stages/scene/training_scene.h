// SPDX-License-Identifier: BSD-3-Clause
// What training needs from a workspace: posed photographs, split into those to
// learn from and those to be measured on, and points to start from.

#ifndef FREEGS_STAGES_SCENE_TRAINING_SCENE_H_
#define FREEGS_STAGES_SCENE_TRAINING_SCENE_H_

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"
#include "splat/images/training_images.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// The views of undistort/ at the photographs' own size, each list in the order
// of the sparse model.
struct PosedPhotos {
  sfm::Reconstruction sparse;
  std::vector<View> train;
  std::vector<View> holdout;
};

// Reads undistort/sparse and, for the split, ingest/images.json; without that
// file all are training photographs. kBadInput names the file that is missing
// or malformed and the stage that writes it.
StatusOr<PosedPhotos> ReadPosedPhotos(const std::filesystem::path& workspace);

struct TrainingScene {
  std::filesystem::path photo_folder;
  PosedPhotos photos;
  std::vector<Eigen::Vector3d> points;  // World frame.
  std::vector<std::array<uint8_t, 3>> colors;
  double extent = 1;  // World units, see SceneExtent.
};

// kUnusableResult when no photograph is left to train on.
StatusOr<TrainingScene> ReadTrainingScene(
    const std::filesystem::path& workspace);

// kBadInput when a photograph cannot be read, or when there is no holdout.
StatusOr<splat::TrainingImages> LoadTrainingPhotos(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool);
StatusOr<splat::TrainingImages> LoadHoldoutPhotos(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool);

// One Gaussian per point.
StatusOr<splat::GaussianModel> InitialModel(const TrainingScene& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_TRAINING_SCENE_H_
