// SPDX-License-Identifier: BSD-3-Clause
// The input of structure from motion: photos, folders and options.

#ifndef FREEGS_SFM_COLMAP_SFM_OPTIONS_H_
#define FREEGS_SFM_COLMAP_SFM_OPTIONS_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/matching/pair_selection.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

struct SfmOptions {
  // The COLMAP program: a path, or a name in PATH.
  std::string colmap = "colmap";

  // Which photos share intrinsics: "auto" (those of one camera group), "single"
  // (all photos of equal size), or "per_image" (none).
  std::string camera = "auto";

  // COLMAP's name of the camera model to estimate, or "auto". With "auto"
  // COLMAP estimates RADIAL, and the result is then adjusted with the simplest
  // cameras that explain its tracks (camera_selection.h).
  std::string camera_model = "auto";

  // Longest side, in pixels, of the images from which features are taken. 0
  // chooses the smallest size, from 800 to 1600, that gives max_features.
  int max_image_size = 0;

  // How many features are kept per photo; those are the largest ones. Of few
  // photos more are kept (FeaturesOf).
  int max_features = 3000;

  // Which pairs of photos are matched.
  PairSelectionOptions pairs;

  // From this number of photos on, a part of them is mapped first, and the
  // others are registered to it (mapping/skeleton.h).
  int fewest_for_skeleton = 200;

  // How many threads and programs run at the same time; <= 0 means one per
  // core. The result does not depend on it.
  int num_threads = 0;

  // Whether a part of so many photos may be mapped first. What comes of it has
  // to be adjusted, which the choice of a camera model does.
  bool MayMapPart(int64_t num_photos) const {
    return num_photos >= fewest_for_skeleton && camera_model == "auto";
  }

  // The camera model that COLMAP estimates.
  const char* ColmapCameraModel() const {
    return camera_model == "auto" ? "RADIAL" : camera_model.c_str();
  }

  // The features to keep of each of so many photos. Few photos overlap little,
  // so that more features connect more of them, and they take little time: of
  // fewer than kFewPhotos 8/3 times max_features are kept, but no more than
  // kManyFeatures unless max_features says so.
  static constexpr int kFewPhotos = 20;
  static constexpr int kManyFeatures = 8000;
  int FeaturesOf(int64_t num_photos) const;

  Status Check() const;
};

struct SfmInput {
  std::filesystem::path photo_folder;
  std::vector<SfmPhoto> photos;  // In the order in which they were taken.

  // The folder of masks, NAME.png for the photo NAME, or empty. No features are
  // taken where a mask is 0. Every photo must have a mask.
  std::filesystem::path mask_folder;

  // The mask of a photo; empty without masks.
  std::filesystem::path MaskOf(const std::string& photo) const {
    return mask_folder.empty() ? mask_folder : mask_folder / (photo + ".png");
  }

  // The folder for database.db, logs/, steps.json and other files of the steps.
  // A call with the same input and options continues after the last finished
  // step of an earlier call, whatever ended that.
  std::filesystem::path work_folder;

  uint64_t seed = 0;
  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_SFM_OPTIONS_H_
