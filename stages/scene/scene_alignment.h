// SPDX-License-Identifier: BSD-3-Clause
// Relates the frame of a scene to the world of other cameras which show
// the same photographs, such as the true ones.
//
//   FREEGS_ASSIGN_OR_RETURN(const sfm::PoseAlignment alignment,
//                           AlignWithViews(scene, cameras.train,
//                           "truth.json"));
//   views = MapViews(cameras.test, alignment.target_from_source);

#ifndef FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_
#define FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_

#include <string>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "sfm/scene/pose_alignment.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Aligns the workspace's cameras with those cameras of `others` that have the
// same names, as sfm::MatchNames compares them: folders at the beginning and
// extensions may differ, but "right/1.jpg" is not "left/1.jpg" where one side
// knows both folders. A camera of `others` that two of the workspace's fit
// equally well is left out. The result maps the scene's frame (source) to that
// of `others` (target); its residuals have the names of `others`. kBadInput
// when fewer than three cameras are paired; the message calls the others
// `source`.
StatusOr<sfm::PoseAlignment> AlignWithViews(const WorkspaceScene& scene,
                                            const std::vector<View>& others,
                                            const std::string& source);

// Brings views from another frame into that of the scene.
std::vector<View> MapViews(const std::vector<View>& others,
                           const Sim3d& other_from_scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_ALIGNMENT_H_
