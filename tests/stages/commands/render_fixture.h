// SPDX-License-Identifier: BSD-3-Clause
// What the tests of `render` share: a workspace, and camera files of it.

#ifndef FREEGS_TESTS_STAGES_COMMANDS_RENDER_FIXTURE_H_
#define FREEGS_TESTS_STAGES_COMMANDS_RENDER_FIXTURE_H_

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "stages/commands/render_command.h"
#include "tests/stages/camera_json.h"
#include "tests/stages/synthetic_workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class RenderFixture : public testing::Test {
 protected:
  Status Render(std::vector<std::string> arguments) {
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    return RunRenderCommand(arguments, context);
  }

  std::string out() const { return (out_.path() / "sub").string(); }
  std::string workspace() const { return workspace_.path().string(); }

  splat::RenderOptions WhiteBackground() const {
    splat::RenderOptions options;
    options.background = {1, 1, 1};
    return options;
  }

  // A camera file of the workspace's views in a world that is scaled, turned
  // and moved, and one more view; `rename` is put before the photos' names.
  nlohmann::json MovedCameras(const std::string& rename) const {
    Sim3d file_from_scene;
    file_from_scene.scale = 2.5;
    file_from_scene.rotation =
        Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized());
    file_from_scene.translation = Eigen::Vector3d(4, -5, 6);
    return Cameras(rename, file_from_scene);
  }

  nlohmann::json Cameras(const std::string& rename,
                         const Sim3d& file_from_scene) const {
    const auto matrix = [&](const Rigid3d& cam_from_scene) {
      return PoseJson(TransformCamera(file_from_scene, cam_from_scene));
    };
    nlohmann::json file;
    file["intrinsics"] = IntrinsicsJson(workspace_.views[0].camera);
    for (const View& view : workspace_.views) {
      file["train"][rename + view.name] = matrix(view.cam_from_world);
    }
    file["test"]["new.png"] = matrix(workspace_.views[3].cam_from_world);
    return file;
  }

  SyntheticWorkspace workspace_;
  TemporaryFolder out_;
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
  ThreadPool pool_{2};
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_COMMANDS_RENDER_FIXTURE_H_
