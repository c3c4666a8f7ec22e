// SPDX-License-Identifier: BSD-3-Clause
// The commands of the program: `freegs_pipeline NAME ARGUMENTS...`. Most
// commands are two functions in stages/commands/NAME_command.h, one that
// declares the words it takes, and one that runs it; bench, plan and query lie
// in their own folders. The functions are:
//   CommandWords NameWords();
//   Status RunNameCommand(const std::vector<std::string>& arguments,
//                         CommandContext& context);
// command_list.cc lists them, and pipeline/main.cc calls the one that is named:
//   CommandContext context{std::cout, std::cerr, cancellation, argv0};
//   const Status status = RunStatusCommand({"workspace"}, context);
// It prints the message of an error on stderr and turns its code into the exit
// code.

#ifndef FREEGS_STAGES_COMMANDS_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_COMMAND_H_

#include <filesystem>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

struct Command;

struct CommandContext {
  std::ostream& out;  // Results, which a caller's script reads.
  std::ostream& err;  // Messages and progress.

  // Ctrl-C cancels it. Long commands then save what they have and return
  // kInterrupted.
  const CancellationToken& cancellation;

  std::string argv0;  // The path by which the program was called.

  // All commands, for those that tell about the others.
  std::span<const Command> commands = {};
};

// For commands that read a workspace: warns when a run is working there, which
// may replace files while they are read.
void WarnOfRun(const std::filesystem::path& workspace, CommandContext& context);

// For commands that write files where the user says. Returns kInvalidArgument
// for a place in the folder of a stage, where a file would replace what the
// stage made or be gone after its next run, for a place among the photos of the
// scene, for a place in a folder or for a file that an option names for a stage
// to read (remembered or in config.ini, such as ingest.masks), and for those
// that the other form below refuses. Of a folder that sfm.import names only the
// files that are imported are kept, the folder itself and that of the model.
// Another folder that contains the workspace leaves places in the workspace
// free. An empty `place` is none. The other errors are those of a config.ini
// that cannot be read.
Status CheckOutputPlace(const std::filesystem::path& workspace,
                        const std::filesystem::path& place);

// Checks the place of output for commands that read no workspace:
// kInvalidArgument for a place in the folder of a stage of any workspace, and
// for the settings and the log of one.
Status CheckOutputPlace(const std::filesystem::path& place);

using CommandFn = Status (*)(const std::vector<std::string>& arguments,
                             CommandContext& context);

struct Command {
  std::string_view name;
  CommandWords (*words)();
  CommandFn run;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_COMMAND_H_
