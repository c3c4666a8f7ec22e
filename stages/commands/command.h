// SPDX-License-Identifier: BSD-3-Clause
// The commands of the program: `freegs_pipeline NAME ARGUMENTS...`. Each
// command is a function in stages/commands/NAME_command.h,
//   Status RunNameCommand(const std::vector<std::string>& arguments,
//                         CommandContext& context);
// pipeline/main.cc lists them and calls the one that is named:
//   CommandContext context{std::cout, std::cerr, cancellation, argv0};
//   const Status status = RunStatusCommand({"workspace"}, context);
// It prints the message of an error on stderr and turns its code into the exit
// code.

#ifndef FREEGS_STAGES_COMMANDS_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_COMMAND_H_

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::stages {

struct CommandContext {
  std::ostream& out;  // Results, which a caller's script reads.
  std::ostream& err;  // Messages and progress.

  // Ctrl-C cancels it. Long commands then save what they have and return
  // kInterrupted.
  const CancellationToken& cancellation;

  std::string argv0;  // The path by which the program was called.
};

// For commands that read a workspace: warns when a run is working there, which
// may replace files while they are read.
void WarnOfRun(const std::filesystem::path& workspace, CommandContext& context);

using CommandFn = Status (*)(const std::vector<std::string>& arguments,
                             CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_COMMAND_H_
