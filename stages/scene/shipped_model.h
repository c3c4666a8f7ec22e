// SPDX-License-Identifier: BSD-3-Clause
// The CLIP model that comes with the program.

#ifndef FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
#define FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_

#include <filesystem>

#include "core/status.h"

namespace freegs::stages {

// models/small_clip of the installed program (beside its bin/, in share/), else
// of the source tree it was built from. kMissingDependency when it is in
// neither place.
StatusOr<std::filesystem::path> FindShippedModel();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
