// SPDX-License-Identifier: BSD-3-Clause
// Finds the photos and films in a folder.

#ifndef FREEGS_PHOTOS_PHOTO_SCAN_H_
#define FREEGS_PHOTOS_PHOTO_SCAN_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::photos {

// True for names that end like a film: mp4, mov, mkv, ...
bool HasFilmExtension(const std::filesystem::path& path);

struct PhotoScan {
  // Files with the extension of an image, in natural order, relative to the
  // folder, with '/' between names. They need not be readable, and their
  // content need not be an image.
  std::vector<std::string> files;

  // Files with the extension of a film, listed like `files`.
  std::vector<std::string> films;

  // Links to folders that were followed, relative to the folder.
  std::vector<std::string> linked_folders;

  // One line for each file or folder that could not be read.
  std::vector<std::string> warnings;
};

// Finds photos and films in a folder and in all folders below it. Files and
// folders whose names begin with a dot are left out. Links to files and folders
// are followed. No folder is visited twice, so loops of links end; a folder
// that lies below `folder` and is also linked to is listed under its own name.
// `excluded` folders are not entered, because the workspace may lie among the
// photos. Returns kBadInput if `folder` is not a folder that can be read.
StatusOr<PhotoScan> ScanPhotos(
    const std::filesystem::path& folder,
    const std::vector<std::filesystem::path>& excluded = {});

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_SCAN_H_
