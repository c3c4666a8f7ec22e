// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/scene_cache.h"

#include <utility>

#include "pipeline/system_info.h"
#include "stages/query/file_stamp.h"

namespace freegs::stages {

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
    // One that is kept would hold threads that nobody needs.
    ThreadPool pool(pipeline::WorkingThreads(threads_));
    FREEGS_ASSIGN_OR_RETURN(SceneParts parts, make_(workspace_, pool));
    parts_ = std::make_shared<const SceneParts>(std::move(parts));
    stamp_ = stamp;
  }
  return parts_;
}

}  // namespace freegs::stages
