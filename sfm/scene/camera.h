// SPDX-License-Identifier: BSD-3-Clause
// A camera with one of COLMAP's camera models, and the projection of points.

#ifndef FREEGS_SFM_SCENE_CAMERA_H_
#define FREEGS_SFM_SCENE_CAMERA_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "sfm/scene/camera_model.h"

namespace freegs::sfm {

// The intrinsics of one lens at one image size. The centre of the top-left
// pixel is (0.5, 0.5).
struct Camera {
  uint32_t id = 0;
  CameraModel model = CameraModel::kPinhole;
  uint64_t width = 0;          // Pixels.
  uint64_t height = 0;         // Pixels.
  std::vector<double> params;  // In the order given at CameraModel.

  double FocalX() const { return params[0]; }
  double FocalY() const { return params[GetCameraModel(model).num_focal - 1]; }
  double PrincipalX() const { return params[GetCameraModel(model).num_focal]; }
  double PrincipalY() const {
    return params[GetCameraModel(model).num_focal + 1];
  }
  // The parameters after focal length and principal point.
  std::span<const double> Distortion() const {
    return std::span(params).subspan(GetCameraModel(model).num_focal + 2);
  }

  // Whether this is a pinhole camera: true for SIMPLE_PINHOLE, PINHOLE and any
  // perspective model whose distortion parameters are all zero. Fisheye models
  // are never pinholes.
  bool IsUndistorted() const;

  // Returns the camera of the resized image: focal lengths and principal point
  // are scaled. When x and y scale differently, models with one focal length
  // get the mean of both.
  Camera Resized(uint64_t new_width, uint64_t new_height) const;

  // Checks the number of parameters, that they are finite, that the image size
  // is one, and that the focal lengths are those of a photograph of this size.
  Status Check() const;
};

// Returns the pixel on which a point of the camera frame (x right, y down,
// z forward) falls. Returns nothing when the point is not in front of the
// camera (z <= 0), for fisheye models too, or when the pixel is not finite.
// `camera` must pass Check(). The equations are those in COLMAP's documentation
// of its camera models: Brown-Conrady distortion as in OpenCV's calib3d, and
// Kannala-Brandt for fisheye lenses.
std::optional<Eigen::Vector2d> Project(const Camera& camera,
                                       const Eigen::Vector3d& point);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_H_
