// SPDX-License-Identifier: BSD-3-Clause
// `doctor`: lists what this machine offers and what it lacks.

#ifndef FREEGS_STAGES_COMMANDS_DOCTOR_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_DOCTOR_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords DoctorWords();

// kMissingDependency, naming the package, when something is missing that the
// pipeline cannot do without.
Status RunDoctorCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_DOCTOR_COMMAND_H_
