// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/scene_database.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "core/io/files.h"
#include "sfm/features/extract_features.h"
#include "sfm/features/image_size.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

Status CheckNames(const SfmInput& input) {
  for (const SfmPhoto& photo : input.photos) {
    const std::string& name = photo.name;
    if (name.empty() || name.find_first_of("\r\n") != std::string::npos ||
        name.front() == ' ' || name.back() == ' ') {
      return BadInputError("photo '" + name +
                           "': COLMAP cannot read a name that begins or ends "
                           "with a space or has a line break; rename it");
    }
  }
  return {};
}

}  // namespace

SceneDatabase::SceneDatabase(const SfmInput& input,
                             const SfmOptions& options,
                             ColmapProgram colmap)
    : options_(options),
      colmap_(std::move(colmap)),
      context_{input, options_, colmap_},
      path_(input.work_folder / "database.db"),
      record_(input.work_folder, colmap_.version()) {
  options_.max_features =
      options.FeaturesOf(static_cast<int64_t>(input.photos.size()));
  context_.num_threads =
      options.num_threads > 0
          ? options.num_threads
          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

StatusOr<std::unique_ptr<SceneDatabase>> SceneDatabase::Build(
    const SfmInput& input, const SfmOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckNames(input));
  FREEGS_ASSIGN_OR_RETURN(
      ColmapProgram colmap,
      ColmapProgram::Find(options.colmap, input.cancellation));
  FREEGS_RETURN_IF_ERROR(CreateFolders(input.work_folder / "logs"));
  std::unique_ptr<SceneDatabase> scene(
      new SceneDatabase(input, options, std::move(colmap)));
  FREEGS_RETURN_IF_ERROR(scene->ChooseSize());
  FREEGS_RETURN_IF_ERROR(scene->Fill());
  std::error_code ignored;
  fs::remove(input.work_folder / "image_list.txt", ignored);
  return scene;
}

Status SceneDatabase::ChooseSize() {
  if (options_.max_image_size != 0) return {};
  if (!record_.Has("features") || record_.image_size() < 64) {
    FREEGS_ASSIGN_OR_RETURN(const int size, ChooseImageSize(context_));
    FREEGS_RETURN_IF_ERROR(record_.SetImageSize(size));
  }
  options_.max_image_size = record_.image_size();
  return {};
}

Status SceneDatabase::Fill() {
  if (!record_.Has("photos")) {
    RemoveDatabase(path_);
    FREEGS_RETURN_IF_ERROR(RegisterPhotos(context_, path_));
    FREEGS_RETURN_IF_ERROR(record_.Add("photos"));
  }
  if (!record_.Has("features")) {
    FREEGS_RETURN_IF_ERROR(ExtractFeatures(context_, path_));
    FREEGS_RETURN_IF_ERROR(record_.Add("features"));
  }
  if (!record_.Has("matches")) {
    FREEGS_ASSIGN_OR_RETURN(
        const MatchedPairs pairs,
        MatchFeatures(context_, path_, record_.portions(), [&](int portion) {
          return record_.AddPortion(portion);
        }));
    FREEGS_RETURN_IF_ERROR(record_.AddMatches(pairs));
  }
  return {};
}

}  // namespace freegs::sfm
