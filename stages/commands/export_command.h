// SPDX-License-Identifier: BSD-3-Clause
// `export WORKSPACE --out FILE`: writes the scene to one file for other
// programs.

#ifndef FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords ExportWords();

// The suffix of FILE, in upper or lower case, chooses the format: .ply
// (splat/scene/ply_io.h) or .splat (splat/scene/splat_format.h). With --what
// instances the Gaussians get the colours of their instances. --only 3,17
// writes only the Gaussians of these instances, --without 3,17 all others.
Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
