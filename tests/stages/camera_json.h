// SPDX-License-Identifier: BSD-3-Clause
// The parts of a camera file (stages/scene/camera_file.h).

#ifndef FREEGS_TESTS_STAGES_CAMERA_JSON_H_
#define FREEGS_TESTS_STAGES_CAMERA_JSON_H_

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/pinhole.h"
#include "core/rigid3d.h"

namespace freegs::stages {

inline nlohmann::json IntrinsicsJson(const Pinhole& camera) {
  return {{"w", camera.width},
          {"h", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy}};
}

// The three rows of a 3x4 matrix.
inline nlohmann::json PoseJson(const Rigid3d& cam_from_world) {
  const Eigen::Matrix<double, 3, 4> pose = cam_from_world.Matrix3x4();
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({pose(r, 0), pose(r, 1), pose(r, 2), pose(r, 3)});
  }
  return rows;
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_CAMERA_JSON_H_
