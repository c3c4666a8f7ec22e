// SPDX-License-Identifier: BSD-3-Clause
// What a trainer needs from a pipeline workspace.

#ifndef FREEGS_BENCH_TRAINING_SCENE_H_
#define FREEGS_BENCH_TRAINING_SCENE_H_

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/reconstruction.h"
#include "splat/gaussian_model.h"
#include "splat/training_images.h"

namespace freegs::bench {

struct TrainingScene {
  std::filesystem::path photo_folder;
  sfm::Reconstruction sparse;
  std::vector<View> train;
  std::vector<View> holdout;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<uint8_t, 3>> colors;
  double extent = 1;
};

// Reads WORKSPACE/undistort and, for the split, WORKSPACE/ingest/images.json.
// kBadInput when a file is missing or no photo is left to train on.
StatusOr<TrainingScene> ReadTrainingScene(
    const std::filesystem::path& workspace);

// kBadInput when a photo cannot be read, or when there is no holdout.
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

}  // namespace freegs::bench

#endif  // FREEGS_BENCH_TRAINING_SCENE_H_
