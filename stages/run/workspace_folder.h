// SPDX-License-Identifier: BSD-3-Clause
// Whether a folder is a workspace.

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

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_WORKSPACE_FOLDER_H_
