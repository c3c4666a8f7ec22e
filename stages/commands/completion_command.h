// SPDX-License-Identifier: BSD-3-Clause
// `completion bash|zsh`: prints a script that makes the shell complete the
// program's words.

#ifndef FREEGS_STAGES_COMMANDS_COMPLETION_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_COMPLETION_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords CompletionWords();

// Prints the script for the commands of the context.
Status RunCompletionCommand(const std::vector<std::string>& arguments,
                            CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_COMPLETION_COMMAND_H_
