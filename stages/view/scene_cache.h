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
#include "stages/view/turns.h"

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
// has another scene. Several threads may use it. One of them makes the parts,
// which can take many seconds. The others do not wait for it: they could be all
// threads of the server.
class SceneCache {
 public:
  // Without `make` there is no 3D viewer.
  SceneCache(std::filesystem::path workspace, MakeSceneFn make)
      : workspace_(std::move(workspace)), make_(std::move(make)) {}

  // Null while another thread makes the parts. kMissingDependency without a
  // viewer, else the errors of `make`.
  StatusOr<std::shared_ptr<const SceneParts>> Get();

 private:
  // What was made of the scene that the workspace has now; null without it.
  std::shared_ptr<const SceneParts> Known();

  const std::filesystem::path workspace_;
  const MakeSceneFn make_;
  Turns turns_{/*max_threads=*/1};
  std::mutex mutex_;  // Guards parts_.
  std::shared_ptr<const SceneParts> parts_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_SCENE_CACHE_H_
