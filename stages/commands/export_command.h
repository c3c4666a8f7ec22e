// SPDX-License-Identifier: BSD-3-Clause
// `export WORKSPACE --out FILE`: the scene in one file for other programs.

#ifndef FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// The suffix of FILE (in any case) says the format: .ply (see
// splat/scene/ply_io.h) or .splat (see splat/scene/splat_format.h). --what
// instances exports the Gaussians in their instances' colours instead of their
// own. --only 3,17 writes the Gaussians of those instances only, --without 3,17
// all others.
Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
