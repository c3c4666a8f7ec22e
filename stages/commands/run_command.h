// SPDX-License-Identifier: BSD-3-Clause
// `run IMAGES WORKSPACE` and `stage STAGE WORKSPACE`: run the stages.

#ifndef FREEGS_STAGES_COMMANDS_RUN_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_RUN_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords RunWords();
CommandWords StageWords();

// Brings all stages from --from to --to up to date. IMAGES is a folder of
// photos or a film. It may be left out when the workspace knows its photos from
// an earlier run; then the options that the workspace remembers are used, too
// (stages/command_line/remembered_options.h), and --forget drops some of them.
Status RunRunCommand(const std::vector<std::string>& arguments,
                     CommandContext& context);

// Redoes one stage with the options that the workspace remembers and those
// given here, even if its result still holds.
Status RunStageCommand(const std::vector<std::string>& arguments,
                       CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_RUN_COMMAND_H_
