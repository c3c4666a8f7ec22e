// SPDX-License-Identifier: BSD-3-Clause
// The first step: photos and their cameras into the database.

#include <charconv>
#include <map>
#include <system_error>
#include <tuple>

#include "core/io/files.h"
#include "core/quantile.h"
#include "sfm/colmap/colmap_output.h"
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

std::string NumberText(double value) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, result.ptr);
}

// COLMAP's start value of a shared camera whose focal length the photos tell;
// empty when they do not.
std::string StartParameters(const CameraGroup& group,
                            const CameraModelInfo& model) {
  std::vector<double> focal;
  for (const SfmPhoto* photo : group.photos) {
    if (photo->focal_px > 0) focal.push_back(photo->focal_px);
  }
  if (!group.shared || focal.size() * 2 <= group.photos.size()) return {};
  std::string text = NumberText(UpperMedian(std::move(focal)));
  if (model.num_focal == 2) text += "," + text;
  text += "," + NumberText(group.photos[0]->width / 2.0);
  text += "," + NumberText(group.photos[0]->height / 2.0);
  for (int i = model.num_focal + 2; i < model.num_params; ++i) {
    // The FOV model divides by its parameter.
    text += model.model == CameraModel::kFov ? ",0.01" : ",0";
  }
  return text;
}

StatusOr<fs::path> WriteImageList(const StepContext& context,
                                  const std::vector<const SfmPhoto*>& photos) {
  std::string text;
  for (const SfmPhoto* photo : photos) text += photo->name + "\n";
  const fs::path path = context.input.work_folder / "image_list.txt";
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, text));
  return path;
}

// COLMAP numbers photos in the order in which their features are ready. So one
// thread takes hardly any features from tiny images.
StatusOr<ColmapArguments> ExtractorArguments(const StepContext& context,
                                             const fs::path& database,
                                             const fs::path& image_list) {
  FREEGS_ASSIGN_OR_RETURN(
      ColmapArguments arguments,
      context.Arguments("feature_extractor", context.input.photos.size()));
  arguments.Require("database_path", database.string());
  arguments.Require("image_path", context.input.photo_folder.string());
  arguments.Require("image_list_path", image_list.string());
  arguments.Prefer({"FeatureExtraction.use_gpu", "SiftExtraction.use_gpu"},
                   "0");
  arguments.Prefer(
      {"FeatureExtraction.num_threads", "SiftExtraction.num_threads"}, "1");
  arguments.Prefer(
      {"FeatureExtraction.max_image_size", "SiftExtraction.max_image_size"},
      "64");
  arguments.Prefer(
      {"SiftExtraction.max_num_features", "FeatureExtraction.max_num_features"},
      "16");
  return arguments;
}

}  // namespace

Status RegisterPhotos(const StepContext& context, const fs::path& database) {
  const CameraModelInfo* model =
      FindCameraModel(std::string_view(context.options.ColmapCameraModel()));
  double finished = 0;
  for (const CameraGroup& group :
       GroupPhotos(context.input, context.options.camera)) {
    FREEGS_ASSIGN_OR_RETURN(const fs::path list,
                            WriteImageList(context, group.photos));
    FREEGS_ASSIGN_OR_RETURN(ColmapArguments arguments,
                            ExtractorArguments(context, database, list));
    arguments.Require("ImageReader.camera_model",
                      context.options.ColmapCameraModel());
    arguments.Require(group.shared ? "ImageReader.single_camera"
                                   : "ImageReader.single_camera_per_image",
                      "1");
    const std::string start = StartParameters(group, *model);
    if (!start.empty()) arguments.Prefer({"ImageReader.camera_params"}, start);

    FREEGS_ASSIGN_OR_RETURN(const ChildCommand command, arguments.Finish());
    const auto on_line = [&](std::string_view line) {
      const auto progress = ParseColmapLine(line);
      if (!progress || progress->kind != ColmapProgress::Kind::kPhotoDone)
        return;
      context.Report("reading photos",
                     finished + progress->done,
                     static_cast<double>(context.input.photos.size()),
                     "");
    };
    FREEGS_ASSIGN_OR_RETURN(
        const ChildResult result,
        RunChild(command, on_line, context.input.cancellation));
    FREEGS_RETURN_IF_ERROR(CheckEnded(context, "feature_extractor", result));
    finished += static_cast<double>(group.photos.size());
  }
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase photos, MatchDatabase::Open(database));
  return photos.ClearFeatures();
}

}  // namespace freegs::sfm
