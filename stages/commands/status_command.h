// SPDX-License-Identifier: BSD-3-Clause
// `status WORKSPACE [--json]`: says what is done, what is not, and why.

#ifndef FREEGS_STAGES_COMMANDS_STATUS_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_STATUS_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords StatusWords();

// Says what `run` would do now with the settings of the last run and those
// given here.
Status RunStatusCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_STATUS_COMMAND_H_
