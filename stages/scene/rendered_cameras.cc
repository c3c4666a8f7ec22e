// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/rendered_cameras.h"

#include <cstddef>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"

namespace freegs::stages {

nlohmann::json RenderedCameras(const std::vector<View>& views,
                               const std::vector<std::string>& names,
                               const Sim3d& world_from_scene) {
  nlohmann::json frames = nlohmann::json::array();
  for (size_t i = 0; i < views.size(); ++i) {
    const Pinhole& camera = views[i].camera;
    const Rigid3d world_from_cam =
        Inverse(TransformCamera(world_from_scene, views[i].cam_from_world));
    const Eigen::Matrix<double, 3, 4> pose = world_from_cam.Matrix3x4();
    nlohmann::json matrix = nlohmann::json::array();
    for (int row = 0; row < 3; ++row) {
      // OpenGL's camera looks along -z, and its y is up.
      matrix.push_back(
          {pose(row, 0), -pose(row, 1), -pose(row, 2), pose(row, 3)});
    }
    matrix.push_back({0, 0, 0, 1});
    frames.push_back({{"file_path", ValidUtf8(names[i])},
                      {"w", camera.width},
                      {"h", camera.height},
                      {"fl_x", camera.fx},
                      {"fl_y", camera.fy},
                      {"cx", camera.cx},
                      {"cy", camera.cy},
                      {"transform_matrix", std::move(matrix)}});
  }
  return {{"camera_model", "PINHOLE"}, {"frames", std::move(frames)}};
}

}  // namespace freegs::stages
