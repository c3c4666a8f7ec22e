// SPDX-License-Identifier: BSD-3-Clause
// Which way is up in a reconstruction, where its middle is and how large it is:
// guesses from how people hold cameras. Recorded beside a model, never applied
// to it.

#ifndef FREEGS_SFM_SCENE_SCENE_FRAME_H_
#define FREEGS_SFM_SCENE_SCENE_FRAME_H_

#include <optional>
#include <string_view>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// How the up direction was found.
enum class UpSource {
  kHorizon,   // Normal to the cameras' horizontal axes, which fan out.
  kCameraUp,  // Mean of the cameras' up axes: the horizontal axes are parallel.
};
std::string_view UpSourceName(UpSource source);

// The largest plane through points that has all cameras on one side.
struct GroundPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Towards the cameras.
  double point_share = 0;  // Of all points, those on it.
  double angle_to_up_deg = 0;
};

struct SceneFrame {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  // In the world, of length 1.
  UpSource source = UpSource::kCameraUp;

  // 0 (a mere guess) to 1, the product of: the share of cameras held level
  // within 5 degrees; how far their horizontal axes fan out; how much the
  // cameras agree which end is up. At most 0.3 for kCameraUp.
  double confidence = 0;

  // Of those cameras, the root mean square angle of the horizontal axis to the
  // horizontal plane.
  double tilt_rms_deg = 0;

  // A check of `up` that does not change it; nothing where no plane holds a
  // tenth of the points.
  std::optional<GroundPlane> ground;

  // What the cameras look at, in the world, and how far away it is: the median
  // over the cameras. One unit of the frame.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double distance = 1;

  // World to frame: z up, the origin at `centre`, x along the horizontal axis
  // of the first camera by name, `distance` becomes 1. A similarity.
  Eigen::Matrix4d frame_from_world = Eigen::Matrix4d::Identity();
};

// kBadInput without images. A pure function of the model.
//
// Photographers hold cameras level, so the x axes of the cameras lie in the
// horizontal plane, whatever the cameras look at: up is what is perpendicular
// to most of them (consensus over pairs of axes, then least squares over those
// that agree), on the side of the mean of the cameras' own up axes. Where these
// cancel out (all look straight down, or one camera rolls), the side that the
// cameras are on is taken, with low confidence.
// Source of the idea: Szeliski, "Image alignment and stitching: a tutorial",
// 2006, section on up vector selection; its plane fit made robust here.
StatusOr<SceneFrame> EstimateSceneFrame(const Reconstruction& model);

// frame.json.
nlohmann::ordered_json SceneFrameToJson(const SceneFrame& frame);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_SCENE_FRAME_H_
