// SPDX-License-Identifier: BSD-3-Clause
// `init WORKSPACE`: a config.ini with every option explained, and a README.

#ifndef FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// What init writes. The texts are part of the program: an installed one needs
// no other file.
std::string ConfigTemplate();
std::string WorkspaceReadme();

// Makes the folder if need be and writes the files it lacks; files that are
// there stay as they are.
Status RunInitCommand(const std::vector<std::string>& arguments,
                      CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_INIT_COMMAND_H_
