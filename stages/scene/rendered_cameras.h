// SPDX-License-Identifier: BSD-3-Clause
// The cameras of rendered pictures, for programs that use the pictures.

#ifndef FREEGS_STAGES_SCENE_RENDERED_CAMERAS_H_
#define FREEGS_STAGES_SCENE_RENDERED_CAMERAS_H_

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/pinhole.h"
#include "core/rigid3d.h"

namespace freegs::stages {

// Returns a transforms.json of the views, whose pictures have the given names.
// Each frame has its own intrinsics, in pixels of its picture. The poses are
// camera-to-world with OpenGL axes, as the form has them, in the world that
// world_from_scene leads to. `views` are in the frame of the scene.
nlohmann::json RenderedCameras(const std::vector<View>& views,
                               const std::vector<std::string>& names,
                               const Sim3d& world_from_scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_RENDERED_CAMERAS_H_
