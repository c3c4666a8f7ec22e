// SPDX-License-Identifier: BSD-3-Clause
// Imports camera poses that another program computed.

#ifndef FREEGS_SFM_IMPORT_IMPORT_MODEL_H_
#define FREEGS_SFM_IMPORT_IMPORT_MODEL_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

// The files found at a path that the user gave for import.
struct ImportSource {
  // The folder of a COLMAP model. If it is empty, `transforms` is not.
  std::filesystem::path colmap_model;

  // transforms.json, or transforms_train.json.
  std::filesystem::path transforms;

  // Those of transforms_test.json and transforms_val.json that exist beside
  // transforms_train.json. Their frames are meant for evaluation.
  std::vector<std::filesystem::path> holdout_transforms;

  // All files whose content decides the result.
  std::vector<std::filesystem::path> Files() const;
};

// The folders in which a COLMAP model is looked for when a folder is imported:
// itself, and sparse/0, sparse and 0 in it. The first model counts.
std::vector<std::filesystem::path> ModelFolders(
    const std::filesystem::path& folder);

// Finds what can be imported at `path`. It may be the folder of a COLMAP model
// (binary or text), a folder that contains one as sparse/0, sparse or 0, a
// transforms file, or a folder with transforms.json or transforms_train.json.
// The message of kBadInput says what was looked for.
StatusOr<ImportSource> FindImportSource(const std::filesystem::path& path);

struct ImportedModel {
  // The images that are among the photos, with the names and in the order of
  // the photos. Intrinsics and features are in pixels of the photos.
  Reconstruction model;

  // Whether the points are random ones, because the source has none.
  bool random_points = false;

  // Photos that the source means for evaluation, in the order of the photos.
  std::vector<std::string> holdout;

  // Whether the source names files of masks. They are not read.
  bool names_masks = false;

  std::vector<std::string> unmatched;  // Names of the source that fit no photo.

  // Photos with a pose that EXIF turned, though their size is the same as
  // before, or the source gives no size. Poses of the stored photo would not be
  // noticed.
  std::vector<std::string> turned;

  std::vector<std::string> warnings;
};

struct ImportOptions {
  int random_points = 10000;  // Their number, when the source has no points.
  uint64_t seed = 0;

  // The name of the folder that the photos come from; empty if it is not known.
  std::string folder = {};
};

// Reads the poses of the given photos:
//
//   FREEGS_ASSIGN_OR_RETURN(const ImportSource source, FindImportSource(path));
//   FREEGS_ASSIGN_OR_RETURN(const ImportedModel imported,
//                           ImportModel(source, photos, ImportOptions()));
//
// MatchNames decides which image of the source is which photo. A pose of a
// photo that EXIF turns may belong to the stored photo or to the upright one;
// if its size is that of the stored one, it is turned, too. Returns kBadInput
// when the source is malformed, when no name fits a photo, and when a photo has
// another shape than its image in the source.
StatusOr<ImportedModel> ImportModel(const ImportSource& source,
                                    const std::vector<SfmPhoto>& photos,
                                    const ImportOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_IMPORT_MODEL_H_
