// SPDX-License-Identifier: BSD-3-Clause
// The scene as the 3D viewer loads it: a description and parts, the most
// important Gaussians first.

#ifndef FREEGS_STAGES_VIEW_SCENE_CACHE_H_
#define FREEGS_STAGES_VIEW_SCENE_CACHE_H_

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// The contents of files; several answers may share one.
struct SceneParts {
  struct Part {
    std::shared_ptr<const std::string> splats;  // splats.spz
    std::shared_ptr<const std::string> labels;  // labels.bin
  };
  std::string description;  // JSON.
  std::vector<Part> parts;
  std::string stamp = {};  // QueryStamp of the files they were made from.
};

// Makes the parts from a workspace.
using MakeSceneFn =
    std::function<StatusOr<SceneParts>(const std::filesystem::path& workspace)>;

// Does so with MakeViewerScene (stages/viewer/viewer_scene.h), whose errors it
// returns.
StatusOr<SceneParts> MakeSceneParts(const std::filesystem::path& workspace);

// Makes the parts when they are first asked for, and again when the workspace
// has another scene. Several threads may use it.
class SceneCache {
 public:
  // Without `make` there is no 3D viewer.
  SceneCache(std::filesystem::path workspace, MakeSceneFn make)
      : workspace_(std::move(workspace)), make_(std::move(make)) {}

  // kMissingDependency without a viewer, else the errors of `make`.
  StatusOr<std::shared_ptr<const SceneParts>> Get();

 private:
  const std::filesystem::path workspace_;
  const MakeSceneFn make_;
  std::mutex mutex_;
  std::string stamp_;
  std::shared_ptr<const SceneParts> parts_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_SCENE_CACHE_H_
