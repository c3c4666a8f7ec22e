// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's camera models: how a point of the camera frame becomes a pixel.

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

// Intrinsics of one lens at one image size. The centre of the top-left pixel is
// (0.5, 0.5).
struct Camera {
  uint32_t id = 0;
  CameraModel model = CameraModel::kPinhole;
  uint64_t width = 0;   // Pixels.
  uint64_t height = 0;  // Pixels.
  std::vector<double> params;

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

  // True for (SIMPLE_)PINHOLE and for any perspective model whose distortion
  // parameters are all zero. (Fisheye models with zeros are not pinholes.)
  bool IsUndistorted() const;

  // The same lens with its image resized: focal lengths and principal point
  // follow. When x and y scale differently, models with one focal length take
  // the mean of both.
  Camera Resized(uint64_t new_width, uint64_t new_height) const;

  // Parameter count, finite values, positive focal length and size.
  Status Check() const;
};

// The pixel of a point in the camera frame (x right, y down, z forward);
// nothing when the point is not in front of the camera (z <= 0; fisheye models
// too) or falls nowhere finite. camera must pass Check().
// Models: Brown-Conrady as in OpenCV's calib3d, and Kannala-Brandt fisheye;
// equations as in COLMAP's documentation of its camera models.
std::optional<Eigen::Vector2d> Project(const Camera& camera,
                                       const Eigen::Vector3d& point);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_H_
