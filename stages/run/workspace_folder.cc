// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/workspace_folder.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "core/io/files.h"
#include "photos/photo_scan.h"
#include "pipeline/fingerprint.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "stages/registry/stage_registry.h"

namespace freegs::stages {

namespace fs = std::filesystem;

namespace {

bool IsBystander(const fs::directory_entry& entry) {
  std::error_code error;
  return pipeline::IsBystander(entry.path().filename().string(),
                               entry.is_directory(error));
}

// Whether an entry of a folder is `place`, or each folder on the way from it
// down to `place` holds nothing else but bystanders.
bool IsOnlyWayTo(const fs::path& place, const fs::path& entry) {
  if (!IsWithin(place, entry)) return false;
  std::error_code error;
  fs::path inner = fs::weakly_canonical(fs::absolute(place, error), error);
  while (inner.has_relative_path() && !IsWithin(entry, inner)) {
    const fs::path folder = inner.parent_path();
    for (const fs::directory_entry& other :
         fs::directory_iterator(folder, error)) {
      if (other.path().filename() != inner.filename() && !IsBystander(other)) {
        return false;
      }
    }
    inner = folder;
  }
  return !error;
}

}  // namespace

Status CheckWorkspaceFolder(const fs::path& workspace,
                            const std::vector<fs::path>& photos) {
  std::error_code error;
  if (!fs::exists(workspace, error)) return Status();
  if (!fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": not a folder");
  }
  const auto holds_photos = [&photos](const fs::path& entry) {
    return std::ranges::any_of(photos, [&entry](const fs::path& place) {
      return IsOnlyWayTo(place, entry);
    });
  };
  bool empty = true;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(workspace, error)) {
    const std::string name = entry.path().filename().string();
    // Command init writes the README. The latter two are left when the first
    // run ends before it has begun.
    empty = empty && (IsBystander(entry) || name == "README.md" ||
                      name == "workspace.json.part" ||
                      entry.path() == pipeline::LogPath(workspace) ||
                      holds_photos(entry.path()));
    for (const char* known : {"workspace.json",
                              "config.ini",
                              "ingest",
                              "sfm",
                              "undistort",
                              "reconstruct"}) {
      if (name == known) return Status();
    }
  }
  if (error) {
    return BadInputError(workspace.string() +
                         ": cannot read: " + error.message());
  }
  if (empty) return Status();
  return BadInputError(workspace.string() +
                       ": holds other files and is not a workspace; give a "
                       "workspace, or, to make one, a new or empty folder (run "
                       "IMAGES WORKSPACE)");
}

Status CheckImagesFolder(const fs::path& images,
                         const fs::path& remembered,
                         const fs::path& workspace) {
  FREEGS_RETURN_IF_ERROR(CheckPhotosPlace(workspace, images));
  std::error_code error;
  if (fs::is_directory(images, error)) {
    if (IsWithin(workspace, images)) {
      return InvalidArgumentError(
          workspace.string() +
          ": the workspace lies inside the photo folder; its own pictures "
          "would be taken for photos. Give a folder outside " +
          images.string());
    }
    return Status();
  }
  if (fs::is_regular_file(images, error) && photos::HasFilmExtension(images)) {
    return Status();
  }
  // Once stage ingest has read the photos, they are no longer needed. Another
  // folder that is not there was mistyped.
  if (images == remembered &&
      pipeline::ReadStageRecord(pipeline::StageFolder(workspace, "ingest"))
          .ok()) {
    return Status();
  }
  return BadInputError(
      images.string() +
      (fs::exists(images, error)
           ? ": not a folder and not a film; give the folder of "
             "the photos, or a film such as a.mp4"
           : ": no such folder of photos, and no such film"));
}

}  // namespace freegs::stages
