// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/run_execution.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>

#include "core/io/json_text.h"
#include "photos/photo_list.h"
#include "pipeline/logger.h"
#include "pipeline/stage_output.h"
#include "pipeline/stage_runner.h"
#include "pipeline/version.h"
#include "stages/registry/stage_registry.h"
#include "stages/run/psnr_run.h"
#include "stages/run/timed_run.h"

namespace freegs::stages {
namespace {

using pipeline::OptionSetting;
using pipeline::OptionTable;

// The last stage that finds out about cameras.
constexpr char kLastOfCameras[] = "undistort";
constexpr char kTraining[] = "reconstruct";

pipeline::StageRunner MakeRunner(const RunRequest& request,
                                 const PipelineOptions& options,
                                 const OptionTable& table,
                                 const CancellationToken& cancellation,
                                 pipeline::Logger& logger) {
  pipeline::StageRunnerOptions runner_options;
  runner_options.workspace = request.workspace;
  runner_options.images = request.info.images;
  runner_options.from = request.from;
  runner_options.to = request.to;
  runner_options.forced = request.forced;
  runner_options.num_threads = options.general.threads;
  runner_options.checkpoint_interval_seconds =
      options.general.checkpoint_interval;
  runner_options.deadline = request.deadline;
  if (!request.forced_reason.empty()) {
    runner_options.forced_reason = request.forced_reason;
  }
  if (!request.way_on.empty()) runner_options.way_on = request.way_on;
  return pipeline::StageRunner(MakeStages(options, table),
                               std::move(runner_options),
                               cancellation,
                               logger);
}

std::filesystem::path MetricsPath(const std::filesystem::path& workspace) {
  return pipeline::StageFolder(workspace, kTraining) / "metrics.json";
}

// Why a training with these metrics.json and options is not whole: the time of
// an earlier run was up before its last iteration, or before the search about
// exposure came to an end. Every search that comes to an end leaves an object
// there, also one that could measure nothing. Empty for a whole training.
std::string WhyNotWhole(const nlohmann::json& metrics,
                        const ReconstructStageOptions& options) {
  const auto done = metrics.find("iterations");
  if (done == metrics.end() || !done->is_number()) return "";
  if (done->get<double>() < options.iterations) {
    return "the training ended after " + std::to_string(done->get<int64_t>()) +
           " of " + std::to_string(options.iterations) + " iterations";
  }
  const auto search = metrics.find("exposure_search");
  if (options.exposure == "auto" && search != metrics.end() &&
      search->is_null()) {
    return "the training had no time to decide whether to learn the exposure "
           "of each photo";
  }
  return "";
}

// Has the training done again if it is not whole. For run WORKSPACE such a
// training is good enough; a goal is not measured by it.
RunRequest WithWholeTraining(RunRequest request,
                             const PipelineOptions& options) {
  if (!options.reconstruct.import.empty()) return request;
  const StatusOr<nlohmann::json> metrics =
      ReadJson(MetricsPath(request.workspace));
  if (!metrics.ok() || !metrics->is_object()) return request;
  const std::string reason = WhyNotWhole(*metrics, options.reconstruct);
  if (reason.empty()) return request;
  request.forced = kTraining;
  request.forced_reason = reason;
  return request;
}

// What a killed run left is put in order before anything is foretold from it.
Status Recover(const std::filesystem::path& workspace) {
  for (const std::string& stage : StageNames()) {
    FREEGS_RETURN_IF_ERROR(pipeline::RecoverStage(workspace, stage));
  }
  return Status();
}

// The stages of `request`, with the settings of the user and those chosen for
// preset auto, which `options` is set to.
StatusOr<std::vector<pipeline::StageForecast>> ForecastOf(
    const RunRequest& request,
    const std::vector<OptionSetting>& settings,
    const std::vector<OptionSetting>& chosen,
    const CancellationToken& cancellation,
    PipelineOptions* options) {
  OptionTable table = MakeOptionTable(options);
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace, settings, table, chosen));
  std::ostringstream ignored;
  pipeline::Logger logger(ignored, /*terminal=*/false, "");
  return MakeRunner(WithWholeTraining(request, *options),
                    *options,
                    table,
                    cancellation,
                    logger)
      .Forecast();
}

// What the run of `request` is expected to take.
StatusOr<ExpectedRun> Expect(const RunRequest& request,
                             const std::vector<OptionSetting>& settings,
                             const std::vector<OptionSetting>& chosen,
                             const CancellationToken& cancellation) {
  PipelineOptions options;
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<pipeline::StageForecast> forecasts,
      ForecastOf(request, settings, chosen, cancellation, &options));
  ExpectedRun expected{.iterations = options.reconstruct.iterations,
                       .max_image_size = options.reconstruct.max_image_size};
  double* part = &expected.cameras;
  bool trained = false;
  for (const pipeline::StageForecast& forecast : forecasts) {
    if (forecast.needed) {
      *part += forecast.need.seconds;
      if (trained) expected.after_training += forecast.need.seconds;
      if (part == &expected.cameras) {
        expected.cameras_tell_pace &= forecast.need.known() && !forecast.begun;
      }
    }
    if (forecast.stage == kLastOfCameras) part = &expected.others;
    trained = trained || forecast.stage == kTraining;
  }
  return expected;
}

// An accuracy is measured on photos that are kept from the training.
Status CheckHoldout(const std::filesystem::path& workspace) {
  FREEGS_ASSIGN_OR_RETURN(
      const photos::PhotoList list,
      photos::ReadPhotoList(
          pipeline::StageFolder(workspace, StageNames().front()) /
          "images.json"));
  const bool has_holdout =
      std::ranges::any_of(list.photos, [](const photos::Photo& photo) {
        return photo.split == photos::PhotoSplit::kHoldout;
      });
  if (has_holdout) return Status();
  return BadInputError(
      "no photos are kept from the training to measure its accuracy by; see "
      "ingest.holdout, ingest.holdout_every and ingest.holdout_list, take more "
      "photos, or run without --at-least");
}

// The PSNR of the holdout photos of a scene that has been trained.
StatusOr<double> HoldoutPsnr(const std::filesystem::path& workspace) {
  const std::filesystem::path path = MetricsPath(workspace);
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json metrics, ReadJson(path));
  const auto psnr = metrics.find("holdout_psnr");
  if (psnr == metrics.end() || !psnr->is_number()) {
    return BadInputError(
        path.string() +
        ": the photos that are kept from the training could not be measured, "
        "because they have no pose or masks leave nothing of them; keep others "
        "(ingest.holdout), or run without --at-least");
  }
  return psnr->get<double>();
}

}  // namespace

Status Execute(const RunRequest& request,
               const PipelineOptions& options,
               const OptionTable& table,
               std::ostream& err,
               const CancellationToken& cancellation) {
  pipeline::Logger logger(
      err, pipeline::IsTerminal(err), pipeline::LogPath(request.workspace));
  logger.LogToFile(
      pipeline::LogLevel::kInfo,
      std::string("freegs_pipeline ") + pipeline::kProgramVersion + " begins");
  if (!request.note.empty()) {
    logger.Log(pipeline::LogLevel::kInfo, request.note);
  }
  if (options.general.verbose) {
    for (const OptionTable::Option& option : table.options()) {
      if (option.section().empty()) continue;
      logger.Log(pipeline::LogLevel::kInfo,
                 "option " + option.name + " = " + option.value());
    }
  }
  return MakeRunner(request, options, table, cancellation, logger).Run();
}

namespace {

StatusOr<bool> ConfigHasPreset(const std::filesystem::path& workspace,
                               const OptionTable& table) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<OptionSetting> config,
                          ConfigSettings(workspace, table));
  return std::ranges::any_of(config, [](const OptionSetting& setting) {
    return setting.name == "general.preset";
  });
}

// kInvalidArgument where config.ini says how long a training shall be. Even if
// it says what --at-least tries first, a longer training may follow.
Status CheckConfigLeavesTraining(const std::filesystem::path& workspace) {
  PipelineOptions options;
  const OptionTable table = MakeOptionTable(&options);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<OptionSetting> config,
                          ConfigSettings(workspace, table));
  for (const OptionSetting& setting : config) {
    if (IsChosenByPsnr(setting.name)) return ChosenByPsnrError(setting.name);
  }
  return Status();
}

// kInvalidArgument where the scene is imported: no training would change it.
// `goal` is the option that a training is to meet.
Status CheckTrains(const std::string& goal,
                   const std::filesystem::path& workspace,
                   const std::vector<OptionSetting>& settings) {
  PipelineOptions options;
  const OptionTable table = MakeOptionTable(&options);
  FREEGS_ASSIGN_OR_RETURN(std::vector<OptionSetting> all,
                          ConfigSettings(workspace, table));
  all.insert(all.end(), settings.begin(), settings.end());
  std::string import;
  for (const OptionSetting& setting : all) {
    if (setting.name == "reconstruct.import") import = setting.value;
  }
  if (import.empty()) return Status();
  return InvalidArgumentError(
      goal +
      " trains a scene, and reconstruct.import takes one that was "
      "trained elsewhere; leave out one of them");
}

// What becomes of a choice where the user decided otherwise.
enum class ChoiceRule { kUserDecides, kMustHold };

// Execute with the settings of the user and those chosen for preset auto. Later
// runs go on with those that hold, if they are to be remembered.
Status ExecuteChosen(RunRequest request,
                     const std::vector<OptionSetting>& settings,
                     const std::vector<OptionSetting>& chosen,
                     ChoiceRule rule,
                     bool remember,
                     std::ostream& err,
                     const CancellationToken& cancellation) {
  PipelineOptions options;
  OptionTable table = MakeOptionTable(&options);
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace, settings, table, chosen));
  for (const OptionSetting& choice : chosen) {
    if (table.Find(choice.name)->value() == choice.value) {
      if (remember) request.info.settings[choice.name] = choice.value;
    } else if (rule == ChoiceRule::kMustHold) {
      return ChosenByPsnrError(choice.name);
    }
  }
  FREEGS_ASSIGN_OR_RETURN(const bool has_preset,
                          ConfigHasPreset(request.workspace, table));
  if (has_preset && remember) {
    // Later runs go on with what was chosen, and not with that preset.
    const PipelineOptions plain;
    request.info.settings["general.preset"] = plain.general.preset;
  }
  FREEGS_RETURN_IF_ERROR(
      pipeline::WriteWorkspaceInfo(request.workspace, request.info));
  return Execute(WithWholeTraining(std::move(request), options),
                 options,
                 table,
                 err,
                 cancellation);
}

}  // namespace

Status ExecuteWithin(double seconds,
                     const std::vector<OptionSetting>& settings,
                     const RunRequest& request,
                     std::ostream& err,
                     const CancellationToken& cancellation) {
  using Clock = std::chrono::steady_clock;
  FREEGS_RETURN_IF_ERROR(CheckTrains("--within", request.workspace, settings));
  FREEGS_RETURN_IF_ERROR(Recover(request.workspace));
  pipeline::Logger logger(
      err, pipeline::IsTerminal(err), pipeline::LogPath(request.workspace));
  TimedRunTasks tasks;
  tasks.log = [&logger](pipeline::LogLevel level, const std::string& text) {
    logger.Log(level, text);
  };
  tasks.now = SteadySeconds;
  tasks.foretell = [&](const std::vector<OptionSetting>& chosen) {
    return Expect(request, settings, chosen, cancellation);
  };
  tasks.run = [&](const std::vector<OptionSetting>& chosen,
                  RunPart part,
                  double end) -> Status {
    RunRequest now = request;
    // Before the photos are read nothing is known to choose by.
    const bool remember = part != RunPart::kPhotos;
    if (!remember) {
      now.to = StageNames().front();
    } else {
      // The same command would have the full time once more, and might choose
      // other options and begin the training anew.
      now.way_on = "run WORKSPACE, without IMAGES and --within,";
    }
    if (part == RunPart::kCameras) now.to = kLastOfCameras;
    now.deadline =
        Clock::time_point(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(end)));
    return ExecuteChosen(now,
                         settings,
                         chosen,
                         ChoiceRule::kUserDecides,
                         remember,
                         err,
                         cancellation);
  };
  return RunWithin(seconds, tasks);
}

Status ExecuteAtLeast(double psnr,
                      const std::vector<OptionSetting>& settings,
                      const RunRequest& request,
                      std::ostream& err,
                      const CancellationToken& cancellation) {
  FREEGS_RETURN_IF_ERROR(CheckConfigLeavesTraining(request.workspace));
  FREEGS_RETURN_IF_ERROR(
      CheckTrains("--at-least", request.workspace, settings));
  FREEGS_RETURN_IF_ERROR(Recover(request.workspace));
  pipeline::Logger logger(
      err, pipeline::IsTerminal(err), pipeline::LogPath(request.workspace));
  PsnrRunTasks tasks;
  tasks.log = [&logger](pipeline::LogLevel level, const std::string& text) {
    logger.Log(level, text);
  };
  tasks.look =
      [&](const std::vector<OptionSetting>& chosen) -> StatusOr<TrainingState> {
    RunRequest now = request;
    now.to = kTraining;
    PipelineOptions options;
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<pipeline::StageForecast> forecasts,
        ForecastOf(now, settings, chosen, cancellation, &options));
    TrainingState state;
    bool done = true;
    for (const pipeline::StageForecast& forecast : forecasts) {
      done = done && !forecast.needed;
      if (forecast.stage == kTraining) state.begun = forecast.begun;
    }
    if (done) {
      FREEGS_ASSIGN_OR_RETURN(state.psnr, HoldoutPsnr(request.workspace));
    }
    return state;
  };
  const auto execute = [&](const RunRequest& now,
                           const std::vector<OptionSetting>& chosen,
                           bool remember) {
    return ExecuteChosen(now,
                         settings,
                         chosen,
                         ChoiceRule::kMustHold,
                         remember,
                         err,
                         cancellation);
  };
  tasks.train =
      [&](const std::vector<OptionSetting>& chosen) -> StatusOr<double> {
    RunRequest now = request;
    now.to = StageNames().front();
    FREEGS_RETURN_IF_ERROR(execute(now, chosen, /*remember=*/false));
    FREEGS_RETURN_IF_ERROR(CheckHoldout(request.workspace));
    now.to = kTraining;
    now.note.clear();
    FREEGS_RETURN_IF_ERROR(execute(now, chosen, /*remember=*/true));
    return HoldoutPsnr(request.workspace);
  };
  tasks.finish = [&](const std::vector<OptionSetting>& chosen) {
    return execute(request, chosen, /*remember=*/true);
  };
  return RunAtLeast(psnr, tasks);
}

}  // namespace freegs::stages
