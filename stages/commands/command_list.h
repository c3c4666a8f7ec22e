// SPDX-License-Identifier: BSD-3-Clause
// The list of all commands.

#ifndef FREEGS_STAGES_COMMANDS_COMMAND_LIST_H_
#define FREEGS_STAGES_COMMANDS_COMMAND_LIST_H_

#include <span>
#include <string>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// All commands, in the order in which the help names them.
std::span<const Command> Commands();

// Returns the command of this name. kInvalidArgument for an unknown one names
// the nearest.
StatusOr<Command> FindCommand(const std::string& name);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_COMMAND_LIST_H_
