// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_alignment.h"

#include <string>
#include <utility>

#include "sfm/import/name_matching.h"

namespace freegs::stages {

StatusOr<sfm::PoseAlignment> AlignWithViews(
    const WorkspaceScene& scene,
    const std::vector<View>& others,
    const std::string& source_of_others) {
  sfm::NamedPoses target;
  for (const View& view : others) target[view.name] = view.cam_from_world;
  std::vector<sfm::SfmPhoto> cameras;
  for (const auto& [name, pose] : target) cameras.emplace_back().name = name;
  std::vector<const View*> views;
  std::vector<std::string> names;
  for (const std::vector<View>* list : {&scene.train, &scene.holdout}) {
    for (const View& view : *list) {
      views.push_back(&view);
      names.push_back(view.name);
    }
  }
  // So that nobody gets the cameras of photographs without a pose.
  names.insert(
      names.end(), scene.without_pose.begin(), scene.without_pose.end());
  sfm::NameMatches match = sfm::MatchNames(names, cameras);
  // Where two photographs fit one camera equally well, one of them has another
  // pose than this camera. Too few pairs are better than a wrong one.
  for (const sfm::NameTie& tie : match.ties) match.photos[tie.taken] = -1;
  sfm::NamedPoses source;
  for (size_t i = 0; i < views.size(); ++i) {
    const int camera = match.photos[i];
    if (camera < 0) continue;
    source[cameras[static_cast<size_t>(camera)].name] =
        views[i]->cam_from_world;
  }
  StatusOr<sfm::PoseAlignment> alignment = sfm::AlignPoses(source, target);
  if (!alignment.ok()) {
    return alignment.status().Annotated("aligning the scene with " +
                                        source_of_others);
  }
  return alignment;
}

std::vector<View> MapViews(const std::vector<View>& others,
                           const Sim3d& other_from_scene) {
  const Sim3d scene_from_other = Inverse(other_from_scene);
  std::vector<View> views = others;
  for (View& view : views) {
    view.cam_from_world =
        TransformCamera(scene_from_other, view.cam_from_world);
  }
  return views;
}

}  // namespace freegs::stages
