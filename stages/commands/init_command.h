// SPDX-License-Identifier: BSD-3-Clause
// `init WORKSPACE`: writes a config.ini that explains every option, and a
// README.

#ifndef FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords InitWords();

// The texts that init writes. They are part of the program, so that an
// installed program needs no other file.
std::string ConfigTemplate();
std::string WorkspaceReadme();

// Makes the folder if it does not exist and writes those of the files that it
// lacks. Existing files stay as they are.
Status RunInitCommand(const std::vector<std::string>& arguments,
                      CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_
