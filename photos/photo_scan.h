// SPDX-License-Identifier: BSD-3-Clause
// Which files of a folder are photos.

#ifndef FREEGS_PHOTOS_PHOTO_SCAN_H_
#define FREEGS_PHOTOS_PHOTO_SCAN_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::photos {

// Order of names as people count: img2 before img10, folder by folder.
// A strict total order of different names.
bool NaturalLess(std::string_view a, std::string_view b);

// True for names that end like a film: mp4, mov, mkv, ...
bool HasFilmExtension(const std::filesystem::path& path);

struct PhotoScan {
  // Files with an image's extension, in natural order, relative to the folder
  // with '/' between names. They need not be readable, nor images.
  std::vector<std::string> files;

  // Files with a film's extension, likewise.
  std::vector<std::string> films;

  // Links to folders that were followed, relative to the folder.
  std::vector<std::string> linked_folders;

  // What could not be looked into, one line each.
  std::vector<std::string> warnings;
};

// Finds photos in a folder and all folders below it. Hidden files and folders
// (a leading dot) are left out. Links to files and folders are followed; no
// folder is visited twice, so loops end and a folder that is linked to keeps
// its own name. `excluded` folders are not entered: the workspace may lie among
// the photos. kBadInput if `folder` is not a folder that can be read.
StatusOr<PhotoScan> ScanPhotos(
    const std::filesystem::path& folder,
    const std::vector<std::filesystem::path>& excluded = {});

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_SCAN_H_
