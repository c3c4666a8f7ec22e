// SPDX-License-Identifier: BSD-3-Clause
// What a command of the program is given: `freegs_pipeline NAME ARGUMENTS...`.
// Every command is a function
//   Status RunNameCommand(const std::vector<std::string>& arguments,
//                         CommandContext& context);
// in stages/commands/NAME_command.h. The program prints the message of an error
// Status on stderr and turns its code into the exit code.

#ifndef FREEGS_STAGES_COMMANDS_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_COMMAND_H_

#include <ostream>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::stages {

struct CommandContext {
  std::ostream& out;  // Results: what a caller's script reads.
  std::ostream& err;  // Messages and progress.

  // Set by Ctrl-C. Long commands save what they have and return kInterrupted.
  const CancellationToken& cancellation;

  std::string argv0;  // The program as it was called, for messages.
};

using CommandFn = Status (*)(const std::vector<std::string>& arguments,
                             CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_COMMAND_H_
