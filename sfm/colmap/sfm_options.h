// SPDX-License-Identifier: BSD-3-Clause
// What structure from motion is given: photographs, folders and options.

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

  // Which photos share intrinsics: "auto" (those of a camera group), "single"
  // (all of one size), or "per_image" (none).
  std::string camera = "auto";

  // COLMAP's name of the lens model to estimate; or "auto": COLMAP estimates
  // RADIAL, then the best model is adjusted with the simplest cameras that
  // explain its tracks (camera_selection.h).
  std::string camera_model = "auto";

  // Longest side, in pixels, of the images that features are taken from; 0
  // takes the smallest, from 800 to 1600, that is enough for max_features.
  int max_image_size = 0;

  // Features kept per photo (those of the largest scale).
  int max_features = 3000;

  // Which pairs of photos are matched.
  PairSelectionOptions pairs;

  // What all attempts beyond the first may cost together, as a multiple of what
  // the first did, when it leaves out photos. 0 for no other attempts.
  double max_retry_cost = 8;

  // Features on the graphics card (COLMAP must have been built for it).
  bool use_gpu = false;

  // Threads and parallel programs; <= 0 takes one per core. Changes nothing
  // about the result.
  int num_threads = 0;

  // What COLMAP is asked to estimate.
  const char* ColmapCameraModel() const {
    return camera_model == "auto" ? "RADIAL" : camera_model.c_str();
  }

  Status Check() const;
};

struct SfmInput {
  std::filesystem::path photo_folder;
  std::vector<SfmPhoto> photos;  // In the order in which they were taken.

  // Masks, as NAME.png for the photo NAME: features where they are 0 are not
  // taken. Every photo has one (newer releases of COLMAP skip photos without).
  // Empty for none.
  std::filesystem::path mask_folder;

  // Where the steps leave their files: database.db, logs/, steps.json. Calling
  // again with the same input and options continues after the last finished
  // step, whatever ended the earlier call.
  std::filesystem::path work_folder;

  uint64_t seed = 0;
  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_SFM_OPTIONS_H_
