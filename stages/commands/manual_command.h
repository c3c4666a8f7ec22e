// SPDX-License-Identifier: BSD-3-Clause
// `manual man|options`: prints the man page, or the page of all options that
// is docs/options.md.

#ifndef FREEGS_STAGES_COMMANDS_MANUAL_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_MANUAL_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords ManualWords();

// Prints the page for the commands of the context.
Status RunManualCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_MANUAL_COMMAND_H_
