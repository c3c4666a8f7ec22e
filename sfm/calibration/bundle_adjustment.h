// SPDX-License-Identifier: BSD-3-Clause
// Bundle adjustment: finds the poses, points and intrinsics that agree best
// with the tracks (Triggs et al., "Bundle adjustment - a modern synthesis",
// 2000).

#ifndef FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_
#define FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct BundleAdjustmentOptions {
  int max_iterations = 50;

  // Stop when a step lowers the cost by less than this share of it.
  double function_tolerance = 1e-5;

  const CancellationToken* cancellation = nullptr;

  Status Check() const;
};

// Moves the poses, points and cameras of a model to where its points project as
// near to the observed features as possible:
//
//   BundleAdjustmentOptions options;
//   options.max_iterations = 20;
//   FREEGS_RETURN_IF_ERROR(AdjustBundle(options, &model));
//
// It minimises the sum of the Cauchy loss, of scale 1 pixel, over the
// reprojection errors, so that observations far off count little, and stops as
// the options say. CanAdjust must hold for the model of every camera. Images
// that name the same camera share its intrinsics.
//
// What stays as it is: principal points, because the photos of one scene hardly
// determine them; points seen less than twice; images with fewer than three
// observations; the errors stored with the points. Observations of points that
// lie behind their camera at the start are left out.
//
// Gauge: the pose of the first adjusted image stays, and so does one coordinate
// of the image farthest from it, which fixes the scale.
//
// One thread does all the work: with several, Ceres adds numbers in a changing
// order, and the result would differ from run to run. Independent adjustments
// may run side by side.
//
// Errors, which leave the model untouched: kBadInput (see CheckReconstruction,
// or a camera model that cannot be adjusted), kUnusableResult (fewer than two
// images with common points, or no finite solution), kInterrupted.
Status AdjustBundle(const BundleAdjustmentOptions& options,
                    Reconstruction* model);

// Whether AdjustBundle can estimate a camera of this model: true for
// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV and OPENCV_FISHEYE.
bool CanAdjust(CameraModel model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_BUNDLE_ADJUSTMENT_H_
