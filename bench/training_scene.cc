// SPDX-License-Identifier: BSD-3-Clause

#include "bench/training_scene.h"

#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "sfm/model_io.h"
#include "sfm/photo_list.h"
#include "sfm/views.h"
#include "splat/initialization.h"

namespace freegs::bench {

namespace fs = std::filesystem;

StatusOr<TrainingScene> ReadTrainingScene(const fs::path& workspace) {
  std::error_code error;
  if (!fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": no such workspace");
  }
  const fs::path sparse = workspace / "undistort" / "sparse";
  if (!fs::is_directory(sparse, error)) {
    return BadInputError(sparse.string() +
                         ": no such folder; run stage undistort first");
  }
  TrainingScene scene;
  scene.photo_folder = workspace / "undistort" / "images";
  FREEGS_ASSIGN_OR_RETURN(scene.sparse, sfm::ReadModel(sparse));
  FREEGS_ASSIGN_OR_RETURN(std::vector<View> views,
                          sfm::MakeViews(scene.sparse));
  FREEGS_ASSIGN_OR_RETURN(
      const sfm::PhotoList photos,
      sfm::ReadPhotoList(workspace / "ingest" / "images.json"));
  std::set<std::string> holdout_names;
  for (const sfm::Photo& photo : photos.photos) {
    if (photo.split == sfm::PhotoSplit::kHoldout) {
      holdout_names.insert(photo.name);
    }
  }
  for (View& view : views) {
    const bool holdout = holdout_names.contains(view.name);
    (holdout ? scene.holdout : scene.train).push_back(std::move(view));
  }
  if (scene.train.empty()) {
    return BadInputError(workspace.string() +
                         ": no posed photo is left to train on");
  }
  for (const sfm::Point3D& point : scene.sparse.points3d) {
    scene.points.push_back(point.xyz);
    scene.colors.push_back(point.rgb);
  }
  scene.extent = splat::SceneExtent(scene.train, scene.points);
  return scene;
}

StatusOr<splat::TrainingImages> LoadTrainingPhotos(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool) {
  return splat::TrainingImages::Load(
      scene.train, scene.photo_folder, options, pool);
}

StatusOr<splat::TrainingImages> LoadHoldoutPhotos(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool) {
  if (scene.holdout.empty()) {
    return BadInputError(
        "the workspace has no holdout photo to measure quality on; choose "
        "some with ingest.holdout_every");
  }
  return splat::TrainingImages::Load(
      scene.holdout, scene.photo_folder, options, pool);
}

StatusOr<splat::GaussianModel> InitialModel(const TrainingScene& scene) {
  return splat::InitializeFromPoints(scene.points, scene.colors, scene.extent);
}

}  // namespace freegs::bench
