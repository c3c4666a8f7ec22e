// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/scene_cache.h"

#include <utility>

#include "core/io/json_text.h"
#include "stages/query/file_stamp.h"
#include "stages/viewer/viewer_scene.h"

namespace freegs::stages {

StatusOr<SceneParts> MakeSceneParts(const std::filesystem::path& workspace) {
  FREEGS_ASSIGN_OR_RETURN(ViewerScene scene, MakeViewerScene(workspace, {}));
  SceneParts result;
  result.description = JsonText(scene.description, -1);
  for (ViewerScene::Part& part : scene.parts) {
    result.parts.push_back(
        {std::make_shared<const std::string>(std::move(part.splats)),
         std::make_shared<const std::string>(std::move(part.labels))});
  }
  return result;
}

StatusOr<std::shared_ptr<const SceneParts>> SceneCache::Get() {
  if (!make_) {
    return MissingDependencyError(
        "the 3D viewer was not built into this program; build it with the "
        "viewer, or look at the report");
  }
  if (auto parts = Known()) return parts;
  const Turns::Turn turn(&turns_);
  if (!turn) return std::shared_ptr<const SceneParts>();
  // The thread that had the turn before may have made them.
  if (auto parts = Known()) return parts;
  const std::string stamp = QueryStamp(workspace_);
  {
    // Two scenes at a time may be too large for the memory.
    const std::lock_guard lock(mutex_);
    parts_ = nullptr;
  }
  FREEGS_ASSIGN_OR_RETURN(SceneParts made, make_(workspace_));
  made.stamp = stamp;
  auto parts = std::make_shared<const SceneParts>(std::move(made));
  const std::lock_guard lock(mutex_);
  parts_ = parts;
  return parts;
}

std::shared_ptr<const SceneParts> SceneCache::Known() {
  const std::string stamp = QueryStamp(workspace_);
  const std::lock_guard lock(mutex_);
  return parts_ != nullptr && parts_->stamp == stamp ? parts_ : nullptr;
}

}  // namespace freegs::stages
