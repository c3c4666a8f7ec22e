// SPDX-License-Identifier: BSD-3-Clause
// Photos and model without lens distortion.

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

  // Receives images/ (the photos, under their names) and sparse/ (the model,
  // binary, PINHOLE cameras only). Created; what is in it is replaced.
  std::filesystem::path output;

  // The COLMAP program, run only when there is distortion to be removed.
  std::string colmap = "colmap";

  // Longest side in pixels of the written photos; 0 keeps their own.
  int max_image_size = 0;

  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
};

struct UndistortionResult {
  Reconstruction model;    // As written.
  bool resampled = false;  // False: the photos are the input's own pixels.
};

// Removes the distortion of all images of `model`. When no camera has any,
// photos are linked (or copied) unchanged, or resized if they are too large.
// kBadInput when a posed photo has no file; kUnusableResult when COLMAP fails
// or leaves distortion behind.
StatusOr<UndistortionResult> Undistort(const Reconstruction& model,
                                       const UndistortionInput& input);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_UNDISTORTION_H_
