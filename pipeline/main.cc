// SPDX-License-Identifier: BSD-3-Clause
// The program freegs_pipeline: finds the command, runs it, and turns its
// outcome into an exit code.

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "core/cancellation.h"
#include "core/out_of_memory.h"
#include "core/status.h"
#include "pipeline/exit_code.h"
#include "pipeline/interrupt.h"
#include "pipeline/option_value.h"
#include "pipeline/version.h"
#include "stages/commands/command.h"
#include "stages/commands/doctor_command.h"
#include "stages/commands/eval_command.h"
#include "stages/commands/export_command.h"
#include "stages/commands/features_command.h"
#include "stages/commands/init_command.h"
#include "stages/commands/model_command.h"
#include "stages/commands/query_command.h"
#include "stages/commands/render_command.h"
#include "stages/commands/run_command.h"
#include "stages/commands/status_command.h"
#include "stages/commands/view_command.h"
#include "stages/registry/pipeline_options.h"

namespace freegs {
namespace {

struct Command {
  std::string_view name;
  std::string_view usage;
  stages::CommandFn run;
};

constexpr Command kCommands[] = {
    {"run",
     "run IMAGES WORKSPACE [--preset fast|balanced|quality] [--from S] "
     "[--to S] [--SECTION.KEY VALUE ...]",
     stages::RunRunCommand},
    {"stage",
     "stage STAGE WORKSPACE [--SECTION.KEY VALUE ...]",
     stages::RunStageCommand},
    {"init", "init WORKSPACE", stages::RunInitCommand},
    {"status", "status WORKSPACE [--json]", stages::RunStatusCommand},
    {"doctor", "doctor", stages::RunDoctorCommand},
    {"render",
     "render WORKSPACE --out DIR [--cameras FILE] "
     "[--what color|depth|instances|semantics]",
     stages::RunRenderCommand},
    {"query",
     "query WORKSPACE (--text WORDS | --example IMAGE | --click VIEW X Y | "
     "--box VIEW X0 Y0 X1 Y1) [--out DIR] [--json] [--cameras FILE] "
     "[--model DIR] [--min-relevancy R] [--max-hits N] [--background]",
     stages::RunQueryCommand},
    {"view",
     "view WORKSPACE [--port N] [--host ADDRESS] [--open]",
     stages::RunViewCommand},
    {"eval",
     "eval WORKSPACE [--gt DIR] [--layout NAME] [--model DIR] "
     "[--text-from instances|gaussians] [--text-threshold R] [--json FILE]",
     stages::RunEvalCommand},
    {"features",
     "features IMAGE --text WORDS [--model DIR] [--out FILE] [--cache DIR] "
     "[--dense-size N] [--size N]",
     stages::RunFeaturesCommand},
    {"export",
     "export WORKSPACE --out FILE [--what color|instances] "
     "[--only ID,... | --without ID,...]",
     stages::RunExportCommand},
    {"model",
     "model FILE.safetensors|FOLDER --out DIR [--merges FILE] "
     "[--dense-size N]",
     stages::RunModelCommand},
};

void PrintHelp() {
  std::cout << "freegs_pipeline: a folder of photographs becomes a 3D scene "
               "that knows its objects.\n\n";
  for (const Command& command : kCommands) {
    std::cout << "  freegs_pipeline " << command.usage << "\n";
  }
  std::cout << "\nfreegs_pipeline COMMAND --help tells more about a command.\n"
               "\nExit codes: 0 done; 1 program or system fault; 2 wrong "
               "usage; 3 bad input;\n4 no usable result; 5 a missing program "
               "or model file; 130 interrupted.\n\nOptions, also in "
               "WORKSPACE/config.ini:\n";
  stages::PipelineOptions options;
  std::cout << stages::MakeOptionTable(&options).Help();
}

StatusOr<Command> FindCommand(const std::string& name) {
  const auto command = std::find_if(
      std::begin(kCommands), std::end(kCommands), [&](const Command& c) {
        return c.name == name;
      });
  if (command == std::end(kCommands)) {
    std::vector<std::string> names;
    for (const Command& known : kCommands) names.emplace_back(known.name);
    const std::string nearest = pipeline::NearestName(name, names);
    return InvalidArgumentError(
        "unknown command " + name +
        (nearest.empty() ? "" : "; did you mean " + nearest + "?") +
        "; see freegs_pipeline --help");
  }
  return *command;
}

// What a command says about itself: its usage and all its options.
Status PrintCommandHelp(const std::string& name) {
  FREEGS_ASSIGN_OR_RETURN(const Command command, FindCommand(name));
  const CancellationToken never;
  stages::CommandContext context{std::cout, std::cerr, never, ""};
  std::cout << "freegs_pipeline " << command.usage << "\n\n"
            << command.run({"--help"}, context).message() << "\n";
  return Status();
}

Status RunCommand(const std::vector<std::string>& words,
                  const std::string& argv0) {
  FREEGS_ASSIGN_OR_RETURN(const Command command, FindCommand(words[0]));
  CancellationToken cancellation;
  const pipeline::InterruptGuard guard(&cancellation);
  stages::CommandContext context{std::cout, std::cerr, cancellation, argv0};
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
    std::cout << "freegs_pipeline " << pipeline::kProgramVersion << "\n";
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
