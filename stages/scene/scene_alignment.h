// SPDX-License-Identifier: BSD-3-Clause
// The workspace's world and that of other cameras of the same photographs.

#ifndef FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_
#define FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_

#include <string>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/pose_alignment.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Aligns the workspace's cameras with the cameras of the same name in `others`:
// equal, or, for those without, equal but for folder and suffix. The result
// maps the workspace's world to that of `others`. kBadInput with fewer than
// three in common; `source` names the others in the message.
StatusOr<sfm::PoseAlignment> AlignWithViews(const WorkspaceScene& scene,
                                            const std::vector<View>& others,
                                            const std::string& source);

// The views of another world as cameras of the workspace's world.
std::vector<View> MapViews(const std::vector<View>& others,
                           const Sim3d& other_from_scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_
