// SPDX-License-Identifier: BSD-3-Clause
// Chooses the simplest camera model that explains the tracks of a
// reconstruction.

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
  // The candidates are all combinations of these models with the sharings
  // below. Combinations that give the same cameras are tried once.
  std::vector<CameraModel> models = {CameraModel::kSimplePinhole,
                                     CameraModel::kPinhole,
                                     CameraModel::kSimpleRadial,
                                     CameraModel::kRadial,
                                     CameraModel::kOpenCv,
                                     CameraModel::kOpenCvFisheye};
  bool shared = true;
  bool per_group = true;

  // A camera per photo is tried with SIMPLE_PINHOLE and SIMPLE_RADIAL only,
  // unless this is the only sharing. It is chosen over the others only when it
  // is clearly better: when it lowers the held-out error by at least a tenth
  // and has a smaller BIC.
  bool per_photo = true;

  // If there are more photos than this, a part of them is taken that sees the
  // same points often (see SamplePhotos). A lens is the same everywhere, and
  // time grows faster than the number of photos.
  size_t max_images = 100;

  // Estimation uses a random part of the points: so many that they have this
  // number of observations in all, and at least 40 observations in each image
  // that has 40.
  size_t max_observations = 10000;

  // How many candidates are estimated at the same time; <= 0 means one per
  // core. The result does not depend on it.
  int num_threads = 0;

  const CancellationToken* cancellation = nullptr;

  Status Check() const;
};

// A candidate and its figures. Errors are in pixels. An error that is not a
// median is a root mean square in which larger residuals count as three times
// the standard deviation of the best candidate's residuals.
struct CameraCandidate {
  CameraModel model = CameraModel::kSimplePinhole;
  CameraSharing sharing = CameraSharing::kShared;
  int parameters = 0;  // Number of estimated intrinsics of all cameras.
  double held_out_error_px = 0;
  double held_out_median_px = 0;
  double rms_px = 0;  // Over the observations used for estimation.

  // The Bayesian information criterion n log(rms^2) + k log n (Schwarz,
  // "Estimating the dimension of a model", 1978), with n residuals, two per
  // observation, and k parameters. Poses and points do not count, because all
  // candidates have equally many of them.
  double bic = 0;
  bool chosen = false;
  std::string refused;  // Why it cannot be chosen; empty if it can be.
  std::vector<Camera> cameras;
};

struct CameraSelection {
  std::vector<CameraCandidate> candidates;  // Fewest parameters first.
  size_t chosen = 0;                        // Position in candidates.
  size_t images = 0;                        // Photos used.
  size_t observations = 0;                  // Used for estimation.
  size_t held_out = 0;                      // Observations used for judging.
};

// Estimates every candidate by bundle adjustment on a part of the observations,
// and measures it on others, which are held out: a random 15 % of those of
// points that three or more images see. Of the candidates whose held-out error
// exceeds the smallest one by at most 1 % or 0.01 pixels, that with the fewest
// parameters is chosen whose BIC exceeds the smallest one by at most 50.
// Candidates that no real lens can have (see CheckLens) are refused.
//
// `model` must be triangulated and near its optimum. The result does not depend
// on the number of threads. Returns kUnusableResult when there is too little to
// choose by: fewer than three images, or fewer than 50 observations to hold
// out.
StatusOr<CameraSelection> SelectCameras(const Reconstruction& model,
                                        const CameraSelectionOptions& options);

// Selects cameras and refines the whole model with them:
//
//   CameraSelectionOptions options;
//   options.per_photo = false;
//   FREEGS_ASSIGN_OR_RETURN(const CameraSelection selection,
//                           RefineCameras(options, &model));
//
// After the selection it adjusts the model with the chosen cameras, removes bad
// observations (see FilterTracks) and adjusts again. Images keep their order. A
// new camera takes the id of the old camera of its first image, or, if that is
// taken, the next id after the largest. On an error the model is untouched.
StatusOr<CameraSelection> RefineCameras(const CameraSelectionOptions& options,
                                        Reconstruction* model);

// Does what RefineCameras does, for a model whose cameras were chosen before:
// kPerGroup means the groups that were noted then (see RestoreCameraGroups). On
// an error the model is untouched and keeps the cameras of the earlier choice.
StatusOr<CameraSelection> RefineCamerasAgain(
    const CameraSelectionOptions& options,
    const CameraGroups& groups,
    Reconstruction* model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_CAMERA_SELECTION_H_
