// SPDX-License-Identifier: BSD-3-Clause
// The program freegs_pipeline: finds the command, runs it, and turns its
// outcome into an exit code.

#include <algorithm>
#include <exception>
#include <fcntl.h>
#include <iostream>
#include <string>
#include <unistd.h>
#include <vector>

#include "core/cancellation.h"
#include "core/out_of_memory.h"
#include "core/status.h"
#include "pipeline/exit_code.h"
#include "pipeline/interrupt.h"
#include "pipeline/version.h"
#include "stages/command_line/command_help.h"
#include "stages/command_line/version_text.h"
#include "stages/commands/command.h"
#include "stages/commands/command_list.h"

namespace freegs {
namespace {

// A file that is opened gets the lowest free number, so a closed standard
// stream would become a file of ours, with what is printed in it. /dev/null
// takes its place. It is opened so that printing to a closed standard output
// still fails.
void OccupyStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1) continue;
    open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR);
  }
}

void PrintHelp() {
  std::vector<stages::CommandWords> all;
  for (const stages::Command& command : stages::Commands()) {
    all.push_back(command.words());
  }
  std::cout << stages::ProgramHelp(all);
}

Status PrintCommandHelp(const std::string& name) {
  FREEGS_ASSIGN_OR_RETURN(const stages::Command command,
                          stages::FindCommand(name));
  std::cout << stages::CommandHelp(command.words());
  return Status();
}

Status RunCommand(const std::vector<std::string>& words,
                  const std::string& argv0) {
  FREEGS_ASSIGN_OR_RETURN(const stages::Command command,
                          stages::FindCommand(words[0]));
  CancellationToken cancellation;
  const bool runs_stages = command.name == "run" || command.name == "stage";
  const pipeline::InterruptGuard guard(&cancellation, runs_stages);
  stages::CommandContext context{
      std::cout, std::cerr, cancellation, argv0, stages::Commands()};
  return command.run({words.begin() + 1, words.end()}, context);
}

Status Run(const std::vector<std::string>& words, const std::string& argv0) {
  const auto asks_for_help = [](const std::string& word) {
    return word == "--help" || word == "-h";
  };
  if (words.empty() || asks_for_help(words[0]) ||
      words == std::vector<std::string>{"help"}) {
    PrintHelp();
    return words.empty() ? InvalidArgumentError("give a command") : Status();
  }
  if (words[0] == "--version") {
    std::cout << stages::VersionText(pipeline::ProgramCommit());
    return Status();
  }
  if (words[0] == "help") return PrintCommandHelp(words[1]);
  if (std::any_of(words.begin() + 1, words.end(), asks_for_help)) {
    return PrintCommandHelp(words[0]);
  }
  return RunCommand(words, argv0);
}

int Main(int argc, char** argv) {
  Status status = Run({argv + 1, argv + argc}, argv[0]);
  if (!std::cout.flush() && status.ok()) {
    status = InternalError(
        "standard output: not all of it could be written; is the disk full, or "
        "has its reader gone?");
  }
  if (!status.ok()) {
    std::cerr << "freegs_pipeline: " << status.message() << "\n";
  }
  return pipeline::ExitCode(status.code());
}

}  // namespace
}  // namespace freegs

int main(int argc, char** argv) {
  // The project's code does not throw; the standard library can when memory
  // runs out, and a stack of "terminate called" helps nobody.
  try {
    freegs::OccupyStandardStreams();
    return freegs::Main(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "freegs_pipeline: "
              << (freegs::IsOutOfMemory(e)
                      ? freegs::OutOfMemoryError().message()
                      : std::string("internal error: ") + e.what())
              << "\n";
    return freegs::pipeline::ExitCode(freegs::StatusCode::kInternal);
  }
}
