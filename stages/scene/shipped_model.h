// SPDX-License-Identifier: BSD-3-Clause
// Finds the small CLIP model that comes with the program.

#ifndef FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
#define FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_

#include <filesystem>

#include "core/status.h"

namespace freegs::stages {

// Returns the folder models/small_clip of the installed program, which is
// ../share/freegs_pipeline/models/small_clip as seen from the folder of the
// executable. Without it, returns the folder in the source tree that the
// program was built from. kMissingDependency when both are missing.
StatusOr<std::filesystem::path> FindShippedModel();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
