// SPDX-License-Identifier: BSD-3-Clause
// Camera poses that somebody else computed.

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

// What a path given for import turned out to be.
struct ImportSource {
  // A COLMAP model folder; or empty and transforms files are given.
  std::filesystem::path colmap_model;

  // transforms.json, or transforms_train.json and, if it is there,
  // transforms_test.json, whose frames are meant for evaluation.
  std::filesystem::path transforms;
  std::filesystem::path test_transforms;

  // All files that decide the result.
  std::vector<std::filesystem::path> Files() const;
};

// Looks at `path`: a COLMAP model folder (binary or text) or a folder above one
// (PATH/sparse/0, PATH/sparse, PATH/0); a transforms file, or a folder with
// transforms.json or transforms_train.json. kBadInput says what was looked for.
StatusOr<ImportSource> FindImportSource(const std::filesystem::path& path);

struct ImportedModel {
  // Only images that are among the photos, under the photos' names, in the
  // order of the photos; intrinsics and features in the photos' pixels.
  Reconstruction model;

  // The source has no points: these are random ones.
  bool random_points = false;

  std::vector<std::string> holdout;  // Photos the source means for evaluation.
  std::vector<std::string> unmatched;  // Its names that fit no photo.
  std::vector<std::string> warnings;
};

struct ImportOptions {
  int random_points = 10000;  // How many, when the source has no points.
  uint64_t seed = 0;
};

// Reads `source` for the given photos (see MatchNames for how names are
// matched). kBadInput when it is malformed, when no name fits a photo, or when
// a photo has another shape than the source's images.
StatusOr<ImportedModel> ImportModel(const ImportSource& source,
                                    const std::vector<SfmPhoto>& photos,
                                    const ImportOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_IMPORT_MODEL_H_
