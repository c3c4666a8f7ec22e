// SPDX-License-Identifier: BSD-3-Clause
// Whether a folder is a workspace, and whether photos can be read for it.

#ifndef FREEGS_STAGES_RUN_WORKSPACE_FOLDER_H_
#define FREEGS_STAGES_RUN_WORKSPACE_FOLDER_H_

#include <filesystem>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// kBadInput for what is no folder, and for a folder that holds other files and
// nothing of a workspace: a mistyped argument must not fill it with stages, or
// put a file among photos that would then count as changed. A file or folder of
// it counts as nothing if it is one of `photos`, where photos may lie, or a
// folder with nothing else in it than, perhaps further down, one of these.
Status CheckWorkspaceFolder(
    const std::filesystem::path& workspace,
    const std::vector<std::filesystem::path>& photos = {});

// Whether the stages can read the photos, a folder or a film, for this
// workspace. `remembered`, which may be empty, are the photos that the
// workspace was made of: once stage ingest has read them, they are no longer
// needed. kBadInput for what is not there or neither; kInvalidArgument for a
// workspace inside the folder of its photos, or photos in the folder of a
// stage.
Status CheckImagesFolder(const std::filesystem::path& images,
                         const std::filesystem::path& remembered,
                         const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_WORKSPACE_FOLDER_H_
