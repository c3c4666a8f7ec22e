// SPDX-License-Identifier: BSD-3-Clause
// Converts a camera to another camera model, and checks that a lens can exist.

#ifndef FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_
#define FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_

#include "core/status.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// Returns the camera of the given model whose image is nearest to that of
// `camera`. The fit concerns the distance from the principal point as a
// function of the angle of the ray, by least squares over the angles in the
// image. It estimates the focal length and the first two radial terms of the
// model. All other terms become 0, also tangential ones; id, size and principal
// point stay. `camera` must pass Check(), and `model` must be one of the six
// models of CanAdjust in bundle_adjustment.h.
Camera ConvertCamera(const Camera& camera, CameraModel model);

// Returns kUnusableResult, and says why, when no real lens has these
// parameters: when a focal length is not between 0.1 and 10 times the longer
// side of the image (COLMAP's bounds), when the two focal lengths differ by
// more than a quarter, when a ray farther from the axis falls nearer to the
// centre of the image, or when the distortion draws the whole half space in
// front of the camera into the image. A fisheye lens may do the last.
// `camera` must pass Check().
Status CheckLens(const Camera& camera);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_CONVERSION_H_
