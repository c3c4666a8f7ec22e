// SPDX-License-Identifier: BSD-3-Clause
// The simplest camera model that explains the tracks of a reconstruction.

#ifndef FREEGS_SFM_CALIBRATION_CAMERA_SELECTION_H_
#define FREEGS_SFM_CALIBRATION_CAMERA_SELECTION_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/calibration/camera_sharing.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct CameraSelectionOptions {
  // Candidates: each model with each sharing. Those that come to the same
  // cameras are tried once.
  std::vector<CameraModel> models = {CameraModel::kSimplePinhole,
                                     CameraModel::kPinhole,
                                     CameraModel::kSimpleRadial,
                                     CameraModel::kRadial,
                                     CameraModel::kOpenCv,
                                     CameraModel::kOpenCvFisheye};
  bool shared = true;
  bool per_group = true;

  // SIMPLE_PINHOLE and SIMPLE_RADIAL only, unless neither of the others is
  // tried; chosen over them only when clearly better (per_photo_gain).
  bool per_photo = true;

  // Points are drawn until they have so many observations, and until each
  // image has at least 40 of its own, if it has.
  size_t max_observations = 10000;

  // Share of the observations of points that three or more images see which
  // are kept from the estimation.
  double held_out_share = 0.15;

  // A candidate is as good as another when its held-out error is at most so
  // much larger: a share, or pixels.
  double tolerance = 0.01;
  double tolerance_px = 0.01;

  // A camera per photo must lower the held-out error by this share.
  double per_photo_gain = 0.1;

  // Candidates estimated at the same time; <= 0: one per core. Changes nothing
  // about the result.
  int num_threads = 0;

  const CancellationToken* cancellation = nullptr;

  Status Check() const;
};

// One row of the table. Errors are in pixels and, unless they are medians,
// root mean squares in which a residual counts at most three times the standard
// deviation of the best candidate's.
struct CameraCandidate {
  CameraModel model = CameraModel::kSimplePinhole;
  CameraSharing sharing = CameraSharing::kShared;
  int parameters = 0;  // Intrinsics estimated, of all cameras.
  double held_out_error_px = 0;
  double held_out_median_px = 0;
  double rms_px = 0;  // Of the observations used for estimation.

  // n log(rms^2) + k log n: n residuals, two per observation; k parameters. The
  // poses and points, equally many for all, are left out. (Schwarz,
  // "Estimating the dimension of a model", 1978.)
  double bic = 0;
  bool chosen = false;
  std::string refused;  // Why it cannot be chosen; empty otherwise.
  std::vector<Camera> cameras;
};

struct CameraSelection {
  std::vector<CameraCandidate> candidates;  // Fewest parameters first.
  size_t chosen = 0;                        // Position in candidates.
  size_t observations = 0;                  // Used for estimation.
  size_t held_out = 0;                      // Observations used for judging.
};

// Estimates every candidate by bundle adjustment on a part of the observations
// and measures it on those held out. Two choices are made: the candidate with
// fewest parameters whose held-out error is within the tolerance of the
// smallest, and the one with the smallest BIC. The simpler of the two is
// chosen: a parameter must convince both.
//
// Candidates that no real lens has (CheckLens) are refused. model is a
// triangulated model near its optimum. The same for any number of threads.
// kUnusableResult when there is too little to choose by: fewer than three
// images, or fewer than 50 observations to hold out.
StatusOr<CameraSelection> SelectCameras(const Reconstruction& model,
                                        const CameraSelectionOptions& options);

// Selects, then adjusts the whole model with the chosen cameras, removes bad
// observations (FilterTracks) and adjusts again. Images keep their order; a
// camera takes the id of the first image's old one, or new ids behind the
// largest. On an error the model is untouched.
StatusOr<CameraSelection> RefineCameras(const CameraSelectionOptions& options,
                                        Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_CAMERA_SELECTION_H_
