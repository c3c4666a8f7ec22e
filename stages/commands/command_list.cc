// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/command_list.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/option_value.h"
#include "stages/bench/bench_command.h"
#include "stages/commands/completion_command.h"
#include "stages/commands/doctor_command.h"
#include "stages/commands/eval_command.h"
#include "stages/commands/export_command.h"
#include "stages/commands/features_command.h"
#include "stages/commands/init_command.h"
#include "stages/commands/manual_command.h"
#include "stages/commands/model_command.h"
#include "stages/commands/query_command.h"
#include "stages/commands/render_command.h"
#include "stages/commands/run_command.h"
#include "stages/commands/status_command.h"
#include "stages/commands/view_command.h"
#include "stages/disturb/disturb_photos.h"
#include "stages/disturb/disturb_poses.h"
#include "stages/disturb/disturbance.h"
#include "stages/plan/plan_command.h"
#include "stages/query/query_request.h"

namespace freegs::stages {
namespace {

// `cancellation` must outlive it.
Disturber MakeDisturber(const CancellationToken& cancellation) {
  Disturber disturber;
  disturber.check = [](const std::string& text) {
    return ParseDisturbance(text).status();
  };
  disturber.changes_poses = [](const std::string& text) {
    const auto disturbance = ParseDisturbance(text);
    return disturbance.ok() && disturbance->ChangesPoses();
  };
  disturber.disturb = [&cancellation](const std::string& text,
                                      const std::filesystem::path& source,
                                      const std::filesystem::path& out,
                                      uint64_t seed) -> Status {
    FREEGS_ASSIGN_OR_RETURN(const Disturbance disturbance,
                            ParseDisturbance(text));
    return disturbance.ChangesPoses()
               ? DisturbPoses(disturbance, source, out, seed)
               : DisturbPhotos(disturbance, source, out, seed, &cancellation);
  };
  return disturber;
}

// The bench and the plan have rooms of their own below this one. The bench
// calls the program for everything else, and is given what it needs of the
// other commands.
Status RunBenchCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  return RunBench(arguments,
                  {context.out,
                   context.err,
                   context.cancellation,
                   EvalWords,
                   MakeDisturber(context.cancellation)});
}

Status RunPlanCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  return RunPlan(arguments, context.out, context.cancellation);
}

constexpr Command kCommands[] = {
    {"run", RunWords, RunRunCommand},
    {"stage", StageWords, RunStageCommand},
    {"plan", PlanWords, RunPlanCommand},
    {"init", InitWords, RunInitCommand},
    {"status", StatusWords, RunStatusCommand},
    {"doctor", DoctorWords, RunDoctorCommand},
    {"render", RenderWords, RunRenderCommand},
    {"query", QueryWords, RunQueryCommand},
    {"view", ViewWords, RunViewCommand},
    {"eval", EvalWords, RunEvalCommand},
    {"bench", BenchWords, RunBenchCommand},
    {"features", FeaturesWords, RunFeaturesCommand},
    {"export", ExportWords, RunExportCommand},
    {"model", ModelWords, RunModelCommand},
    {"completion", CompletionWords, RunCompletionCommand},
    {"manual", ManualWords, RunManualCommand},
};

}  // namespace

std::span<const Command> Commands() { return kCommands; }

StatusOr<Command> FindCommand(const std::string& name) {
  std::vector<std::string> names;
  for (const Command& command : kCommands) {
    if (command.name == name) return command;
    names.emplace_back(command.name);
  }
  const std::string nearest = pipeline::NearestName(name, names);
  return InvalidArgumentError(
      "unknown command " + name +
      (nearest.empty() ? "" : "; did you mean " + nearest + "?") +
      "; see freegs_pipeline --help");
}

}  // namespace freegs::stages
