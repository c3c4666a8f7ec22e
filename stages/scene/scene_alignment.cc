// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_alignment.h"

#include <filesystem>
#include <map>
#include <utility>

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

}  // namespace

StatusOr<sfm::PoseAlignment> AlignWithViews(
    const WorkspaceScene& scene,
    const std::vector<View>& others,
    const std::string& source_of_others) {
  sfm::NamedPoses target;
  std::map<std::string, std::vector<std::string>> names_by_stem;
  for (const View& view : others) {
    target[view.name] = view.cam_from_world;
    names_by_stem[fs::path(view.name).stem().string()].push_back(view.name);
  }
  sfm::NamedPoses source;
  std::vector<const View*> without_match;
  for (const std::vector<View>* views : {&scene.train, &scene.holdout}) {
    for (const View& view : *views) {
      if (target.contains(view.name)) {
        source[view.name] = view.cam_from_world;
      } else {
        without_match.push_back(&view);
      }
    }
  }
  const auto stem_of = [](const View& view) {
    return fs::path(view.name).stem().string();
  };
  std::map<std::string, int> num_without_match;
  for (const View* view : without_match) ++num_without_match[stem_of(*view)];
  for (const View* view : without_match) {
    const auto found = names_by_stem.find(stem_of(*view));
    // A stem that several photos share, here or there, is ambiguous.
    if (found != names_by_stem.end() && found->second.size() == 1 &&
        num_without_match[stem_of(*view)] == 1) {
      source.emplace(found->second[0], view->cam_from_world);
    }
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
