// SPDX-License-Identifier: BSD-3-Clause
// What training needs from a workspace: photographs with poses, split into
// those that are trained on and the holdout that measures quality, and the
// points that the first Gaussians are made of.
//
//   FREEGS_ASSIGN_OR_RETURN(const TrainingScene scene,
//                           ReadTrainingScene(workspace));
//   FREEGS_ASSIGN_OR_RETURN(splat::TrainingImages images,
//                           LoadPhotos(scene, scene.photos.train,
//                                      image_options, pool));
//   FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel model, InitialModel(scene));

#ifndef FREEGS_STAGES_SCENE_TRAINING_SCENE_H_
#define FREEGS_STAGES_SCENE_TRAINING_SCENE_H_

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"
#include "splat/images/training_images.h"
#include "splat/scene/gaussian_model.h"
#include "splat/scene/model_frame.h"

namespace freegs::stages {

// The views of undistort/ at the photographs' own size. Each list is in the
// order of the names. Poses and points are in `frame`, not in the world.
struct PosedPhotos {
  splat::ModelFrame frame;
  sfm::Reconstruction sparse;
  std::vector<View> train;
  std::vector<View> holdout;

  // The names of the usable photographs of ingest/images.json that have no
  // pose, in ascending order.
  std::vector<std::string> without_pose;
};

// Reads undistort/sparse, and the split from ingest/images.json. Without that
// file all photographs are for training. kBadInput names the file that is
// missing or malformed; for a missing one also the stage that writes it.
StatusOr<PosedPhotos> ReadPosedPhotos(const std::filesystem::path& workspace);

// The folder of the masks that stage undistort wrote; empty if it wrote none.
std::filesystem::path TrainingMaskFolder(
    const std::filesystem::path& workspace);

struct TrainingScene {
  std::filesystem::path photo_folder;
  std::filesystem::path mask_folder;  // Empty: the workspace has no masks.
  PosedPhotos photos;  // Without the sparse model, which is empty.
  std::vector<Eigen::Vector3d> points;         // In photos.frame.
  std::vector<std::array<uint8_t, 3>> colors;  // RGB, one per point.
  double extent = 1;  // In units of photos.frame; see splat::SceneExtent.
};

// Reads the posed photographs and the points of undistort/sparse. The errors
// are those of ReadPosedPhotos, and kUnusableResult when no photograph is left
// to train on.
StatusOr<TrainingScene> ReadTrainingScene(
    const std::filesystem::path& workspace);

// Loads the pixels and masks of photographs of the scene. options.mask_folder
// is not looked at. kBadInput when a photograph or mask cannot be read, and
// kInterrupted when `cancellation` (null: never) asks to stop.
StatusOr<splat::TrainingImages> LoadPhotos(
    const TrainingScene& scene,
    std::span<const View> views,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation = nullptr);

// Loads the holdout photographs as LoadPhotos does; nothing if there are none.
StatusOr<std::optional<splat::TrainingImages>> LoadHoldout(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation = nullptr);

// Makes one Gaussian per point; see splat::InitializeFromPoints.
StatusOr<splat::GaussianModel> InitialModel(const TrainingScene& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_TRAINING_SCENE_H_
