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
    "freegs_pipeline model clip-vit-base-patch16 --out clip_vitb16, then use "
    "--bootstrap.model clip_vitb16 and query --text.";

// Returns the folder models/small_clip of the installed program, which is
// ../share/freegs_pipeline/models/small_clip as seen from the folder of the
// executable. Without it, returns the folder in the source tree that the
// program was built from. kMissingDependency when both are missing.
StatusOr<std::filesystem::path> FindShippedModel();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SHIPPED_MODEL_H_
