// SPDX-License-Identifier: BSD-3-Clause
// The pictures that stage bootstrap writes: which instance each pixel shows.

#ifndef FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_
#define FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "pipeline/stage.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Writes instances/VIEW.png (16-bit instance ids, 0 for none) for every view
// and preview/VIEW.png (the photo tinted by instance) for num_previews of them,
// evenly spread, below context.output. `instance_of_gaussian` has one label per
// Gaussian, -1 for none. Files are written atomically, and files that an
// interrupted run with the same inputs and options has left are kept. The
// errors are kInterrupted and those of reading photographs and writing files.
Status WriteInstanceMaps(int num_previews,
                         const WorkspaceScene& scene,
                         const std::vector<View>& views,
                         const std::vector<int32_t>& instance_of_gaussian,
                         pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_INSTANCE_MAPS_H_
