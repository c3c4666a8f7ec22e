// SPDX-License-Identifier: BSD-3-Clause
// Removes the lens distortion of photos and of a reconstruction.

#ifndef FREEGS_SFM_COLMAP_UNDISTORTION_H_
#define FREEGS_SFM_COLMAP_UNDISTORTION_H_

#include <filesystem>
#include <string>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct UndistortionInput {
  std::filesystem::path photo_folder;

  // The output folder, which is created if it is missing. It receives images/,
  // with the photos under their names, and sparse/, with the model as binary
  // files with PINHOLE cameras only. Both replace what is there.
  std::filesystem::path output;

  // The COLMAP program. It runs only when a camera has distortion.
  std::string colmap = "colmap";

  // Longest side, in pixels, of the written photos; 0 keeps their sizes.
  int max_image_size = 0;

  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
};

struct UndistortionResult {
  Reconstruction model;    // As written.
  bool resampled = false;  // If false, the photos have unchanged pixels.
};

// Removes the distortion of all images of `model`:
//
//   UndistortionInput input;
//   input.photo_folder = workspace / "ingest" / "photos";
//   input.output = workspace / "undistort";
//   FREEGS_ASSIGN_OR_RETURN(const UndistortionResult result,
//                           Undistort(model, input));
//
// When no camera has distortion, photos are copied without change, and those
// that are too large are resized. Returns kBadInput when a photo of the model
// has no file, and kUnusableResult when COLMAP fails or when its result still
// has distortion.
StatusOr<UndistortionResult> Undistort(const Reconstruction& model,
                                       const UndistortionInput& input);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_UNDISTORTION_H_
