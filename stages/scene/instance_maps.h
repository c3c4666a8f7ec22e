// SPDX-License-Identifier: BSD-3-Clause
// Pictures of which instance is where, written by stage bootstrap.

#ifndef FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_
#define FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "pipeline/stage.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct InstanceMapOptions {
  int max_image_size = 0;  // Longest side in pixels; 0 is the view's own.
  int num_previews = 6;    // Views, evenly spread, that get a coloured one.
};

// instances/VIEW.png and preview/VIEW.png below the stage's output. They are
// written atomically and depend on inputs and options only: those that an
// interrupted run left are kept. Errors: kInterrupted, and what reading
// photographs and writing files fail with.
Status WriteInstanceMaps(const InstanceMapOptions& options,
                         const WorkspaceScene& scene,
                         const std::vector<View>& views,
                         const std::vector<int32_t>& instance_of_gaussian,
                         pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_
