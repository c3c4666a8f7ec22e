// SPDX-License-Identifier: BSD-3-Clause
// Finds the small CLIP model that comes with the program.

#ifndef FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
#define FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_

#include <filesystem>
#include <string_view>

#include "core/status.h"

namespace freegs::stages {

// What to do when the small model does not know what it sees.
inline constexpr std::string_view kOfficialModelAdvice =
    "The official CLIP knows more: download it as docs/clip.md says, run "
    "freegs_pipeline model clip-vit-base-patch16 --out clip_vitb16, then "
    "freegs_pipeline run WORKSPACE --bootstrap.model clip_vitb16, and ask "
    "again.";

// Returns ../share/freegs_pipeline/models/small_clip as seen from the folder of
// the executable, in a build folder as well as where the program is installed.
// kMissingDependency when it is missing.
StatusOr<std::filesystem::path> FindShippedModel();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
