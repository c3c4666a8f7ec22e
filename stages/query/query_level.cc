// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_level.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "semantics/instances/hierarchy.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/working_frame.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The part of the instance that the pixel shows most of. For levels above it,
// any part of the instance will do where the pixel shows none. kInvalidArgument
// where there is no part. The scene has its hierarchy.
StatusOr<int32_t> ClickedPart(const QueryScene& scene,
                              const ClickedInstance& clicked,
                              int level,
                              ThreadPool& pool) {
  // All other instances are one part: without them a pixel that shows several
  // would count as empty.
  std::vector<int32_t> parts = scene.hierarchy->part_of_gaussian;
  const int32_t other = *std::max_element(parts.begin(), parts.end()) + 1;
  for (size_t g = 0; g < parts.size(); ++g) {
    if (scene.labels[g] == clicked.id - 1) continue;
    parts[g] = scene.labels[g] >= 0 ? other : -1;
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<semantics::ClickHit> hits,
                          semantics::QueryClick(scene.scene->model,
                                                parts,
                                                clicked.view,
                                                scene.scene->render,
                                                clicked.pixel,
                                                pool));
  const auto hit =
      std::find_if(hits.begin(), hits.end(), [other](const auto& candidate) {
        return candidate.id - 1 != other;
      });
  int32_t part = -1;
  if (hit != hits.end()) {
    part = hit->id - 1;
  } else if (level > 0) {
    // Upwards all parts of an instance lead to the same region.
    const auto any = std::find_if(parts.begin(), parts.end(), [&](int32_t p) {
      return p >= 0 && p != other;
    });
    if (any != parts.end()) part = *any;
  }
  if (part < 0) {
    return InvalidArgumentError(
        "that pixel shows no part of instance " + std::to_string(clicked.id) +
        " that bootstrap/hierarchy.json knows; click another pixel of it");
  }
  return part;
}

// An id that no instance has.
int FreeId(const QueryScene& scene) {
  // Somebody may have taken instances out of the list.
  int id = 0;
  for (const int32_t label : scene.labels) id = std::max(id, label + 2);
  for (const semantics::Instance& instance : scene.instances) {
    id = std::max(id, instance.id + 1);
  }
  return id;
}

}  // namespace

StatusOr<int> AddLevel(const fs::path& workspace,
                       const ClickedInstance& clicked,
                       int level,
                       ThreadPool& pool,
                       QueryScene* scene) {
  const splat::GaussianModel& model = scene->scene->model;
  if (!scene->hierarchy) {
    FREEGS_ASSIGN_OR_RETURN(scene->hierarchy,
                            ReadSceneHierarchy(workspace, model.size()));
  }
  const semantics::Hierarchy& hierarchy = *scene->hierarchy;
  FREEGS_ASSIGN_OR_RETURN(const int32_t part,
                          ClickedPart(*scene, clicked, level, pool));
  const int32_t around = semantics::RegionAround(hierarchy, part, level);
  const std::vector<uint8_t> inside = semantics::GaussiansOf(hierarchy, around);

  const int id = FreeId(*scene);
  std::vector<int32_t> region(inside.size(), -1);
  for (size_t g = 0; g < inside.size(); ++g) {
    // What is wider has all of the instance, also Gaussians of no part.
    const bool of_clicked = scene->labels[g] == clicked.id - 1;
    if (inside[g] == 0 && !(level > 0 && of_clicked)) continue;
    region[g] = 0;
    scene->labels[g] = id - 1;
  }
  semantics::Instance instance = semantics::BuildInstances(
      model,
      region,
      1,
      {&hierarchy.quality[around], 1},
      /*background=*/{},
      semantics::VerticalOfBoxes(scene->photos, scene->instances),
      {},
      pool)[0];
  instance = InWorld(scene->scene->frame, std::move(instance));
  instance.id = id;
  scene->instances.push_back(std::move(instance));
  return id;
}

}  // namespace freegs::stages
