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
  const std::lock_guard lock(mutex_);
  const std::string stamp = QueryStamp(workspace_);
  if (parts_ == nullptr || stamp != stamp_) {
    parts_ = nullptr;
    FREEGS_ASSIGN_OR_RETURN(SceneParts parts, make_(workspace_));
    parts.stamp = stamp;
    parts_ = std::make_shared<const SceneParts>(std::move(parts));
    stamp_ = stamp;
  }
  return parts_;
}

}  // namespace freegs::stages
