// SPDX-License-Identifier: BSD-3-Clause
// Bundle adjustment (Triggs et al., "Bundle adjustment - a modern synthesis",
// 2000): poses, points and intrinsics that agree best with the tracks.

#ifndef FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_
#define FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_

#include <cstddef>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct BundleAdjustmentOptions {
  // Scale of the Cauchy loss, in pixels: residuals well above count less.
  double loss_scale_px = 1.0;

  int max_iterations = 50;

  // Stop when a step lowers the cost by less than this share.
  double function_tolerance = 1e-5;

  // Keep all intrinsics as they are.
  bool fixed_intrinsics = false;

  const CancellationToken* cancellation = nullptr;

  Status Check() const;
};

struct BundleAdjustmentReport {
  size_t observations = 0;  // Used.
  size_t behind = 0;        // Left out: behind their camera at the start.
  int iterations = 0;
  bool converged = false;   // False: stopped by max_iterations.
  double initial_cost = 0;  // Half the sum of robust squared residuals.
  double final_cost = 0;
};

// Adjusts the model's poses, points and cameras, which are of the models that
// CanAdjust; images that name the same camera share its intrinsics. Principal
// points stay: they are hardly determined by photos of one scene. So do points
// seen less than twice and images with fewer than three observations.
//
// Gauge: the pose of the first adjusted image stays, and with it one
// coordinate of the image farthest from it, which fixes the scale. Point errors
// are not updated.
//
// Always one thread: with several, Ceres adds in changing order, and the result
// would differ from run to run. Independent adjustments may run side by side.
//
// Errors, model untouched: kBadInput (see CheckReconstruction, or a camera
// model that cannot be adjusted), kUnusableResult (fewer than two images with
// common points; no finite solution), kInterrupted.
StatusOr<BundleAdjustmentReport> AdjustBundle(
    const BundleAdjustmentOptions& options, Reconstruction* model);

// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE.
bool CanAdjust(CameraModel model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_
