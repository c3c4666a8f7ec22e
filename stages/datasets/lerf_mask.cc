// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/lerf_mask.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "stages/datasets/mask_folders.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Parses text that is a whole number and nothing else.
std::optional<size_t> ParseIndex(const std::string& text) {
  size_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// The indices of the photographs that are not for training. Nothing when
// images_train does not say which ones are.
std::optional<std::vector<size_t>> TestPhotos(const fs::path& scene,
                                              const DatasetPhotos& photos) {
  std::set<std::string> train;
  for (const std::string& name : FilesIn(scene / "images_train")) {
    train.insert(PhotoStem(name));
  }
  if (train.empty()) return std::nullopt;
  std::vector<size_t> test;
  for (size_t i = 0; i < photos.names.size(); ++i) {
    if (!train.contains(PhotoStem(photos.names[i]))) test.push_back(i);
  }
  return test;
}

StatusOr<size_t> FindPhoto(const fs::path& scene,
                           const std::string& folder,
                           const DatasetPhotos& photos,
                           const std::optional<std::vector<size_t>>& test) {
  // A folder name can be both a photograph's name and a number when photographs
  // are called 0.jpg, 1.jpg, ... It is taken as a name unless that photograph
  // is one to train on.
  for (size_t i = 0; i < photos.names.size(); ++i) {
    if (PhotoStem(photos.names[i]) != folder) continue;
    if (!test || std::binary_search(test->begin(), test->end(), i)) return i;
  }
  const std::string where = (scene / "test_mask" / folder).string();
  const std::optional<size_t> index = ParseIndex(folder);
  if (!index) {
    return BadInputError(where +
                         ": no photograph that is not for training has "
                         "this name");
  }
  if (!test) {
    return BadInputError(where + ": a number of a test view, but without " +
                         (scene / "images_train").string() +
                         " nobody knows which photographs those are");
  }
  if (*index >= test->size()) {
    return BadInputError(where + ": there are only " +
                         std::to_string(test->size()) +
                         " photographs that are not in images_train");
  }
  return (*test)[*index];
}

}  // namespace

StatusOr<GroundTruth> ReadLerfMask(const fs::path& scene) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<MaskFolder> folders,
                          ListMaskFolders(scene / "test_mask"));
  FREEGS_ASSIGN_OR_RETURN(const DatasetPhotos photos, ReadDatasetPhotos(scene));
  const std::optional<std::vector<size_t>> test = TestPhotos(scene, photos);
  std::vector<std::pair<size_t, MaskFolder>> views;
  std::set<size_t> used;
  for (const MaskFolder& folder : folders) {
    FREEGS_ASSIGN_OR_RETURN(const size_t photo,
                            FindPhoto(scene, folder.name, photos, test));
    if (!used.insert(photo).second) {
      return BadInputError((scene / "test_mask" / folder.name).string() +
                           ": a second folder of masks for " +
                           photos.names[photo]);
    }
    views.emplace_back(photo, folder);
  }
  return TruthOfMasks(scene, photos, views);
}

}  // namespace freegs::stages
