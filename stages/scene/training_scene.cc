// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/training_scene.h"

#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "photos/photo_list.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/views.h"
#include "splat/scene/initialization.h"
#include "stages/scene/working_frame.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The photo list of stage ingest. Empty when the workspace has none, as with
// cameras that somebody else put there.
StatusOr<photos::PhotoList> ReadPhotos(const fs::path& workspace) {
  const fs::path path = workspace / "ingest" / "images.json";
  std::error_code error;
  if (!fs::exists(path, error)) return photos::PhotoList();
  return photos::ReadPhotoList(path);
}

}  // namespace

StatusOr<PosedPhotos> ReadPosedPhotos(const fs::path& workspace) {
  const fs::path sparse = workspace / "undistort" / "sparse";
  std::error_code error;
  if (!fs::exists(sparse, error)) {
    return BadInputError(sparse.string() +
                         ": no such file or folder; run stage undistort first");
  }
  PosedPhotos posed;
  FREEGS_ASSIGN_OR_RETURN(posed.sparse, sfm::ReadModel(sparse));
  FREEGS_ASSIGN_OR_RETURN(std::vector<View> views,
                          sfm::MakeViews(posed.sparse));
  posed.frame = ChooseFrame(posed.sparse, views);
  MoveToFrame(posed.frame, &posed.sparse);
  FREEGS_ASSIGN_OR_RETURN(views, sfm::MakeViews(posed.sparse));
  FREEGS_ASSIGN_OR_RETURN(const photos::PhotoList photos,
                          ReadPhotos(workspace));
  std::set<std::string> holdout_names, without_pose;
  for (const photos::Photo& photo : photos.photos) {
    if (photo.usable()) without_pose.insert(photo.name);
    if (photo.split == photos::PhotoSplit::kHoldout) {
      holdout_names.insert(photo.name);
    }
  }
  for (View& view : views) {
    without_pose.erase(view.name);
    const bool holdout = holdout_names.contains(view.name);
    (holdout ? posed.holdout : posed.train).push_back(std::move(view));
  }
  posed.without_pose.assign(without_pose.begin(), without_pose.end());
  return posed;
}

fs::path TrainingMaskFolder(const fs::path& workspace) {
  const fs::path folder = workspace / "undistort" / "masks";
  std::error_code error;
  return fs::is_directory(folder, error) ? folder : fs::path();
}

StatusOr<TrainingScene> ReadTrainingScene(const fs::path& workspace) {
  TrainingScene scene;
  scene.photo_folder = workspace / "undistort" / "images";
  scene.mask_folder = TrainingMaskFolder(workspace);
  FREEGS_ASSIGN_OR_RETURN(scene.photos, ReadPosedPhotos(workspace));
  if (scene.photos.train.empty()) {
    return UnusableResultError(
        "no posed photo is left to train on; choose fewer holdout photos "
        "(ingest.holdout_every)");
  }
  for (const sfm::Point3D& point : scene.photos.sparse.points3d) {
    scene.points.push_back(point.xyz);
    scene.colors.push_back(point.rgb);
  }
  scene.extent = splat::SceneExtent(scene.photos.train, scene.points);
  // Nobody looks at features and tracks any more. Those of a thousand photos
  // would take a hundred megabytes through the whole training.
  scene.photos.sparse = {};
  return scene;
}

StatusOr<splat::TrainingImages> LoadPhotos(
    const TrainingScene& scene,
    std::span<const View> views,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  splat::TrainingImagesOptions with_masks = options;
  with_masks.mask_folder = scene.mask_folder;
  return splat::TrainingImages::Load(
      views, scene.photo_folder, with_masks, pool, cancellation);
}

StatusOr<std::optional<splat::TrainingImages>> LoadHoldout(
    const TrainingScene& scene,
    const splat::TrainingImagesOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  std::optional<splat::TrainingImages> images;
  if (scene.photos.holdout.empty()) return images;
  FREEGS_ASSIGN_OR_RETURN(
      images,
      LoadPhotos(scene, scene.photos.holdout, options, pool, cancellation));
  return images;
}

StatusOr<splat::GaussianModel> InitialModel(const TrainingScene& scene) {
  return splat::InitializeFromPoints(scene.points, scene.colors, scene.extent);
}

}  // namespace freegs::stages
