// SPDX-License-Identifier: BSD-3-Clause
// The same lens in another camera model, and whether a lens can exist.

#ifndef FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_
#define FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_

#include "core/status.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// The camera of the given model whose image is nearest to that of `camera`:
// the distance from the principal point as a function of the ray's angle is
// fitted, by least squares over the angles within the image, with the model's
// focal length and its first two radial terms. Further terms become 0, also
// tangential ones; id, size and principal point stay. camera must pass Check();
// model must be perspective or fisheye with a polynomial: the six models of
// CanAdjust in bundle_adjustment.h.
Camera ConvertCamera(const Camera& camera, CameraModel model);

// kUnusableResult, and why, when no real lens has these parameters: a focal
// length beyond 0.1 to 10 times the longer side (COLMAP's bounds), pixels that
// differ in width and height by more than a quarter, or an image in which rays
// farther from the axis land nearer to its centre. camera must pass Check().
Status CheckLens(const Camera& camera);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_
