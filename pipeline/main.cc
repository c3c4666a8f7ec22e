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
  std::cout << "\nExit codes: 0 done; 1 program or system fault; 2 wrong "
               "usage; 3 bad input;\n4 no usable result; 5 a missing program "
               "or model file; 130 interrupted.\n\nOptions, also in "
               "WORKSPACE/config.ini:\n";
  stages::PipelineOptions options;
  std::cout << stages::MakeOptionTable(&options).Help();
}

Status Run(const std::vector<std::string>& words,
           const CancellationToken& cancellation,
           const std::string& argv0) {
  const std::string& name = words[0];
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
  const std::vector<std::string> arguments(words.begin() + 1, words.end());
  if (std::find(arguments.begin(), arguments.end(), "--help") !=
      arguments.end()) {
    std::cout << "freegs_pipeline " << command->usage << "\n";
    return Status();
  }
  stages::CommandContext context{std::cout, std::cerr, cancellation, argv0};
  return command->run(arguments, context);
}

int Main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty() || words[0] == "--help" || words[0] == "-h" ||
      words[0] == "help") {
    PrintHelp();
    return pipeline::ExitCode(words.empty() ? StatusCode::kInvalidArgument
                                            : StatusCode::kOk);
  }
  if (words[0] == "--version") {
    std::cout << "freegs_pipeline " << pipeline::kProgramVersion << "\n";
    return 0;
  }
  CancellationToken cancellation;
  const pipeline::InterruptGuard guard(&cancellation);
  const Status status = Run(words, cancellation, argv[0]);
  std::cout.flush();
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
