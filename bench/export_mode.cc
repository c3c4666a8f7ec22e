// SPDX-License-Identifier: BSD-3-Clause

#include <cstdint>
#include <cstdio>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "bench/training_modes.h"
#include "core/io/files.h"
#include "sfm/scene/model_io.h"
#include "stages/scene/training_scene.h"

namespace freegs::bench {
namespace {

namespace fs = std::filesystem;

// The images of the views, their cameras, and all points, whose tracks lose the
// other images: a trainer starts from the same points as ours.
sfm::Reconstruction Restrict(const sfm::Reconstruction& model,
                             const std::vector<View>& views) {
  std::set<std::string> names;
  for (const View& view : views) names.insert(view.name);
  sfm::Reconstruction result;
  std::set<uint32_t> image_ids, camera_ids;
  for (const sfm::PosedImage& image : model.images) {
    if (!names.contains(image.name)) continue;
    image_ids.insert(image.id);
    camera_ids.insert(image.camera_id);
    result.images.push_back(image);
  }
  for (const sfm::Camera& camera : model.cameras) {
    if (camera_ids.contains(camera.id)) result.cameras.push_back(camera);
  }
  for (sfm::Point3D point : model.points3d) {
    std::erase_if(point.track, [&](const sfm::TrackElement& element) {
      return !image_ids.contains(element.image_id);
    });
    result.points3d.push_back(std::move(point));
  }
  return result;
}

// A hard link where the file system allows one.
Status LinkOrCopy(const fs::path& from, const fs::path& to) {
  FREEGS_RETURN_IF_ERROR(CreateFolders(to.parent_path()));
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return Status();
  fs::copy_file(from, to, error);
  if (!error) return Status();
  return BadInputError(from.string() + ": cannot be copied to " + to.string() +
                       ": " + error.message());
}

}  // namespace

Status RunExport(const ExportOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const stages::TrainingScene scene,
                          stages::ReadTrainingScene(options.workspace));
  const fs::path images = options.output / "images";
  const fs::path sparse = options.output / "sparse" / "0";
  for (const fs::path& path : {images, sparse}) {
    std::error_code error;
    if (fs::exists(path, error)) {
      return InvalidArgumentError(path.string() +
                                  " exists already; name another folder");
    }
  }
  for (const View& view : scene.photos.train) {
    FREEGS_RETURN_IF_ERROR(
        LinkOrCopy(scene.photo_folder / view.name, images / view.name));
  }
  // Not in the frame of our training: RunEvaluate reads files in the world.
  FREEGS_ASSIGN_OR_RETURN(
      const sfm::Reconstruction world,
      sfm::ReadModel(options.workspace / "undistort" / "sparse"));
  const sfm::Reconstruction model = Restrict(world, scene.photos.train);
  FREEGS_RETURN_IF_ERROR(sfm::WriteModel(sparse, model));
  std::printf(
      "%s: %zu images, %zu cameras, %zu points; %zu holdout images "
      "left out\n",
      options.output.string().c_str(),
      model.images.size(),
      model.cameras.size(),
      model.points3d.size(),
      scene.photos.holdout.size());
  return Status();
}

}  // namespace freegs::bench
