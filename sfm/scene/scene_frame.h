// SPDX-License-Identifier: BSD-3-Clause
// Estimates which way is up in a reconstruction, where its middle is and how
// large it is, from the way in which people hold cameras. The estimate is
// stored beside the model and does not change it.

#ifndef FREEGS_SFM_SCENE_SCENE_FRAME_H_
#define FREEGS_SFM_SCENE_SCENE_FRAME_H_

#include <optional>
#include <string_view>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// How the up direction was found.
enum class UpSource {
  // Up is the normal of the plane of the cameras' horizontal axes, which point
  // in different directions.
  kHorizon,
  // Up is the mean of the cameras' up axes, because their horizontal axes are
  // nearly parallel.
  kCameraUp,
};
std::string_view UpSourceName(UpSource source);

// The largest plane through points that has all cameras on one side.
struct GroundPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Towards the cameras.
  double point_share = 0;  // The share of all points that lie on the plane.
  double angle_to_up_deg = 0;
};

struct SceneFrame {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  // In the world, of length 1.
  UpSource source = UpSource::kCameraUp;

  // From 0, a mere guess, to 1. It is the product of three numbers: the share
  // of cameras that are level to within 5 degrees, how far their horizontal
  // axes spread in direction, and how far the cameras agree which end is up. At
  // most 0.3 for kCameraUp.
  double confidence = 0;

  // Root mean square angle, over the level cameras, between the camera's
  // horizontal axis and the horizontal plane.
  double tilt_rms_deg = 0;

  // For comparison with `up`, which does not depend on it. Nothing when no
  // plane has a tenth of the points.
  std::optional<GroundPlane> ground;

  // The point that the cameras look at, in the world, and its median distance
  // from the cameras, which is one unit of the frame (see EstimateFocus).
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double distance = 1;

  // The similarity from the world to the frame: z points up, the origin is
  // `centre`, x points along the horizontal axis of the first camera by name,
  // and `distance` becomes 1.
  Eigen::Matrix4d frame_from_world = Eigen::Matrix4d::Identity();
};

// Estimates the frame of a model. Returns kBadInput when the model has no
// images. The result depends on the model only.
//
// Photographers hold cameras level. So the x axes of the cameras lie in the
// horizontal plane, whatever the cameras look at, and up is the direction
// perpendicular to most of them. A consensus over pairs of axes finds it, and
// least squares over the axes that agree refine it. Of the two opposite
// directions, the one nearer to the mean of the cameras' own up axes is taken.
// Where these cancel out, because all cameras look straight down or a camera
// rolls, the side on which the cameras are is taken, with low confidence.
// The idea is that of Szeliski, "Image alignment and stitching: a tutorial",
// 2006, section on up vector selection; the plane fit here is robust.
StatusOr<SceneFrame> EstimateSceneFrame(const Reconstruction& model);

// The content of frame.json.
nlohmann::ordered_json SceneFrameToJson(const SceneFrame& frame);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_SCENE_FRAME_H_
