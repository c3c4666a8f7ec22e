// SPDX-License-Identifier: BSD-3-Clause
// The first step: photos and their cameras into the database.

#include <algorithm>
#include <map>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/quantile.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// Photos of one COLMAP call: they share a camera (or each has its own).
struct CameraGroup {
  std::vector<const SfmPhoto*> photos;
  bool shared = true;
};

std::vector<CameraGroup> GroupPhotos(const SfmInput& input,
                                     const std::string& camera) {
  if (camera == "per_image") {
    CameraGroup group;
    group.shared = false;
    for (const SfmPhoto& photo : input.photos) group.photos.push_back(&photo);
    return {group};
  }
  // A camera has one image size, whatever the group says.
  std::map<std::tuple<int, int, int>, size_t> index;
  std::vector<CameraGroup> groups;
  for (const SfmPhoto& photo : input.photos) {
    const int group = camera == "single" ? 0 : photo.camera_group;
    const auto [it, added] = index.emplace(
        std::tuple(group, photo.width, photo.height), groups.size());
    if (added) groups.emplace_back();
    groups[it->second].photos.push_back(&photo);
  }
  return groups;
}

// Where COLMAP starts with a camera.
std::vector<double> StartParameters(const SfmPhoto& photo,
                                    double focal_px,
                                    const CameraModelInfo& model) {
  if (focal_px <= 0) focal_px = GuessedFocal(photo);
  std::vector<double> params(model.num_focal, focal_px);
  params.push_back(photo.width / 2.0);
  params.push_back(photo.height / 2.0);
  // The FOV model divides by its parameter.
  params.resize(model.num_params,
                model.model == CameraModel::kFov ? 0.01 : 0.0);
  return params;
}

// The focal length of a shared camera, if most of its photos tell it; else 0.
double SharedFocal(const CameraGroup& group) {
  std::vector<double> told;
  for (const SfmPhoto* photo : group.photos) {
    if (photo->focal_px > 0) told.push_back(photo->focal_px);
  }
  if (told.size() * 2 <= group.photos.size()) return 0;
  return UpperMedian(std::move(told));
}

// Cameras of the group's photos that have an id.
std::vector<PhotoCamera> CamerasOf(const CameraGroup& group,
                                   const CameraModelInfo& model,
                                   const std::map<std::string, uint32_t>& ids) {
  const double shared_focal = group.shared ? SharedFocal(group) : 0;
  std::vector<PhotoCamera> cameras;
  for (const SfmPhoto* photo : group.photos) {
    const auto id = ids.find(photo->name);
    if (id == ids.end()) continue;
    PhotoCamera camera;
    camera.photo_id = id->second;
    camera.width = photo->width;
    camera.height = photo->height;
    if (photo->camera) {
      camera.model = static_cast<int>(photo->camera->model);
      camera.params = photo->camera->params;
      camera.focal_known = true;
    } else {
      const double focal = group.shared ? shared_focal : photo->focal_px;
      camera.model = static_cast<int>(model.model);
      camera.params = StartParameters(*photo, focal, model);
      camera.focal_known = focal > 0;
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

// A folder of tiny pictures with the names of the photos, which COLMAP reads in
// their stead. It decodes in one thread, and would take half a minute for a
// hundred photos of 12 megapixels.
class StandIns {
 public:
  explicit StandIns(const fs::path& work_folder)
      : folder_(work_folder / "stand_ins") {
    Remove();  // What a run that was killed left.
  }
  ~StandIns() { Remove(); }
  StandIns(const StandIns&) = delete;
  StandIns& operator=(const StandIns&) = delete;

  const fs::path& folder() const { return folder_; }

  Status Write(const std::vector<SfmPhoto>& photos) const {
    constexpr int kSide = 32;
    const ImageU8 picture(kSide, kSide, 1, 128);
    // The first one of each suffix, which tells the format.
    std::map<fs::path, fs::path> made;
    for (const SfmPhoto& photo : photos) {
      const fs::path path = folder_ / photo.name;
      FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
      const auto [first, added] = made.emplace(path.extension(), path);
      if (added) {
        FREEGS_RETURN_IF_ERROR(WriteImage(path, picture));
        continue;
      }
      std::error_code error;
      fs::copy_file(first->second, path, error);
      if (error) {
        return InternalError(path.string() +
                             ": cannot be written: " + error.message());
      }
    }
    return {};
  }

 private:
  void Remove() const {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  fs::path folder_;
};

StatusOr<fs::path> WriteImageList(const StepContext& context,
                                  const std::vector<const SfmPhoto*>& photos) {
  std::string text;
  for (const SfmPhoto* photo : photos) text += photo->name + "\n";
  const fs::path path = context.input.work_folder / "image_list.txt";
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, text));
  return path;
}

// COLMAP numbers photos in the order in which their features are ready, so it
// gets one thread.
StatusOr<ColmapArguments> ExtractorArguments(const StepContext& context,
                                             const fs::path& database,
                                             const fs::path& image_folder,
                                             const fs::path& image_list) {
  FREEGS_ASSIGN_OR_RETURN(
      ColmapArguments arguments,
      context.Arguments("feature_extractor", context.input.photos.size()));
  arguments.Require("database_path", database.string());
  arguments.Require("image_path", image_folder.string());
  arguments.Require("image_list_path", image_list.string());
  arguments.Prefer({"FeatureExtraction.use_gpu", "SiftExtraction.use_gpu"},
                   "0");
  arguments.Prefer(
      {"FeatureExtraction.num_threads", "SiftExtraction.num_threads"}, "1");
  return arguments;
}

}  // namespace

Status RegisterPhotos(const StepContext& context, const fs::path& database) {
  const CameraModelInfo* model =
      FindCameraModel(std::string_view(context.options.ColmapCameraModel()));
  const StandIns pictures(context.input.work_folder);
  FREEGS_RETURN_IF_ERROR(pictures.Write(context.input.photos));
  const std::vector<CameraGroup> groups =
      GroupPhotos(context.input, context.options.camera);
  for (const CameraGroup& group : groups) {
    FREEGS_ASSIGN_OR_RETURN(const fs::path list,
                            WriteImageList(context, group.photos));
    FREEGS_ASSIGN_OR_RETURN(
        ColmapArguments arguments,
        ExtractorArguments(context, database, pictures.folder(), list));
    arguments.Require("ImageReader.camera_model",
                      context.options.ColmapCameraModel());
    arguments.Require(group.shared ? "ImageReader.single_camera"
                                   : "ImageReader.single_camera_per_image",
                      "1");
    FREEGS_ASSIGN_OR_RETURN(const ChildCommand command, arguments.Finish());
    FREEGS_ASSIGN_OR_RETURN(
        const ChildResult result,
        RunChild(command, nullptr, context.input.cancellation));
    FREEGS_RETURN_IF_ERROR(CheckEnded(context, "feature_extractor", result));
  }
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase filled, MatchDatabase::Open(database));
  FREEGS_ASSIGN_OR_RETURN(const auto ids, filled.PhotoIds());
  for (const CameraGroup& group : groups) {
    FREEGS_RETURN_IF_ERROR(filled.SetCameras(CamerasOf(group, *model, ids)));
  }
  return filled.ClearFeatures();
}

}  // namespace freegs::sfm
