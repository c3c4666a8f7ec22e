// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/run_command.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <ostream>
#include <system_error>
#include <utility>

#include "core/io/files.h"
#include "core/text.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "stages/command_line/completion_values.h"
#include "stages/command_line/remembered_options.h"
#include "stages/export/html.h"
#include "stages/query/suggested_questions.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/presets.h"
#include "stages/registry/stage_registry.h"
#include "stages/run/duration.h"
#include "stages/run/psnr_run.h"
#include "stages/run/run_execution.h"
#include "stages/run/workspace_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::OptionSetting;
using pipeline::OptionTable;
using pipeline::WorkspaceInfo;

// Without its networks a stage lacks a part of the program.
constexpr char kModelOption[] = "bootstrap.model";

// Whether a stage has a result, or what an interrupted run left. If so, the
// runner speaks of the stage's inputs before the stage itself reads its
// options.
bool HasBegun(const fs::path& workspace, const std::string& stage) {
  std::error_code error;
  return pipeline::ReadStageRecord(pipeline::StageFolder(workspace, stage))
             .ok() ||
         fs::exists(pipeline::PartialFolder(workspace, stage), error);
}

// A path that is not there is mistyped, unless the workspace remembers it. A
// stage that has not begun says so itself. Of one that has, this is said before
// stages before it are done anew. Of an option that is given several times the
// last one counts.
Status CheckGivenPaths(const fs::path& workspace,
                       const OptionTable& table,
                       const std::vector<OptionSetting>& given,
                       const std::map<std::string, std::string>& remembered) {
  std::map<std::string, std::string> last;
  for (const OptionSetting& setting : given) {
    last[setting.name] = setting.value;
  }
  for (const auto& [name, value] : last) {
    const OptionTable::Option* option = table.Find(name);
    if (!option->spec.is_path || value.empty()) continue;
    std::error_code error;
    if (fs::exists(value, error)) continue;
    const auto before = remembered.find(name);
    if (before != remembered.end() &&
        before->second == pipeline::DisplayPath(workspace, value)) {
      continue;
    }
    if (!HasBegun(workspace, option->section())) continue;
    const std::string fault =
        "--" + name + ": " + value + ": no such file or folder";
    return name == kModelOption ? MissingDependencyError(fault)
                                : BadInputError(fault);
  }
  return Status();
}

// The runner checks this, too, but only once the settings have been stored.
Status CheckOrder(const std::string& from, const std::string& to) {
  const std::vector<std::string> names = StageNames();
  if (std::ranges::find(names, from) <= std::ranges::find(names, to)) {
    return Status();
  }
  return InvalidArgumentError("stage " + from + " comes after " + to +
                              "; the order is " + Joined(names));
}

// Nothing if there is nothing to ask. The scene is finished, so the run does
// not fail when memory or threads are short for this; OpenCV throws then.
std::vector<std::vector<std::string>> QuestionsToTry(
    const fs::path& workspace) {
  try {
    const auto questions = SuggestQuestions(workspace, 3);
    if (questions.ok()) return *questions;
  } catch (const std::exception&) {
  }
  return {};
}

// Tells where to look at the finished scene, and what to ask it.
// `given` is the workspace as the command line has it.
void TellResult(const fs::path& workspace,
                const std::string& given,
                std::ostream& out) {
  const fs::path page = workspace / "export" / "report" / "index.html";
  std::error_code error;
  if (!fs::exists(page, error)) return;
  out << "Open the page of the scene:\n  "
      << "file://" + EncodeUrlPath(page.string()) << "\n";
  const auto questions = QuestionsToTry(workspace);
  if (questions.empty()) return;
  out << "Ask the scene, for instance:\n";
  for (const std::vector<std::string>& question : questions) {
    out << "  freegs_pipeline query " << ShellWord(given);
    for (const std::string& word : question) out << ' ' << ShellWord(word);
    out << '\n';
  }
}

struct RunWordsTargets {
  PipelineOptions options;
  std::string from;
  std::string to;
  std::string within;
  std::string at_least;
  std::vector<std::vector<std::string>> forget;
};

struct StageTargets {
  PipelineOptions options;
  std::vector<std::vector<std::string>> forget;
};

CommandWords DescribeRun(RunWordsTargets* targets) {
  CommandWords words("run",
                     "Brings all stages up to date: photographs in, a scene "
                     "that knows its objects out.",
                     MakeOptionTable(&targets->options));
  words.AddArgument({.name = "IMAGES",
                     .help = "Folder of the photos, or a film. Without it, "
                             "photos and options are those that the workspace "
                             "remembers from earlier commands.",
                     .optional = true});
  words.AddArgument(WorkspaceArgument());
  const std::vector<std::string> stages = StageNames();
  targets->from = stages.front();
  targets->to = stages.back();
  words.AddOption("from",
                  &targets->from,
                  {.help = "First stage to bring up to date; earlier ones are "
                           "used as they are.",
                   .value_name = "STAGE",
                   .choices = stages});
  words.AddOption("to",
                  &targets->to,
                  {.help = "Last stage to bring up to date.",
                   .value_name = "STAGE",
                   .choices = stages});
  words.AddOption("within",
                  &targets->within,
                  {.help = "Ends after this time, such as 90s, 5m or 1h30m: "
                           "chooses the values of preset auto, and stops "
                           "training early if it must.",
                   .value_name = "TIME"});
  words.AddOption("at-least",
                  &targets->at_least,
                  {.help = "Trains no longer than it takes until the photos "
                           "kept from training are reproduced so well, such as "
                           "psnr=27, in dB.",
                   .value_name = "ACCURACY"});
  AddForgetOption(&targets->forget, &words);
  return words;
}

CommandWords DescribeStage(StageTargets* targets) {
  CommandWords words("stage",
                     "Redoes one stage with the options that the workspace "
                     "remembers and those given here, even if its result still "
                     "holds.",
                     MakeOptionTable(&targets->options));
  words.AddArgument(
      {.name = "STAGE", .help = "The stage to redo.", .choices = StageNames()});
  words.AddArgument(WorkspaceArgument());
  AddForgetOption(&targets->forget, &words);
  return words;
}

// Takes over what the workspace remembers, without what the command line does
// not go on with. Notes what the run then uses and what it does not.
Status Recall(const WorkspaceInfo& before,
              const RunWordsTargets& targets,
              const OptionTable::CommandLine& line,
              const OptionTable& table,
              RunRequest* request) {
  request->info = before;
  FREEGS_RETURN_IF_ERROR(ForgetOptions(targets.forget, table, &request->info));
  std::map<std::string, std::string>& settings = request->info.settings;
  const std::string others = OtherOptionsText(settings, line.settings);
  const bool anew = line.positional.size() == 2 && targets.forget.empty();
  if (anew) settings.clear();
  if (!others.empty()) {
    request->note =
        anew ? "run: options of earlier commands do not hold any more: " +
                   others + " (run WORKSPACE, without IMAGES, keeps them)"
             : "run: uses remembered options: " + others;
  }
  return Status();
}

// The photos of the run are `images`; if that is empty, those that the
// workspace remembers.
Status TakeImages(const fs::path& images,
                  const fs::path& remembered,
                  RunRequest* request) {
  if (!images.empty()) request->info.images = images;
  if (request->info.images.empty()) {
    return InvalidArgumentError(
        request->workspace.string() +
        ": does not know its photos yet; give both: run IMAGES WORKSPACE");
  }
  return CheckImagesFolder(
      request->info.images, remembered, request->workspace);
}

// What a run of all stages with preset auto is to keep to: --within or
// --at-least.
struct RunGoal {
  std::optional<double> seconds;
  std::optional<double> psnr;

  bool given() const { return seconds || psnr; }
};

// Takes the goal out of the settings of the command line, and preset auto,
// which goes with it.
StatusOr<RunGoal> TakeGoal(OptionTable::CommandLine* line) {
  const OptionSetting* goal = nullptr;
  const std::string* preset = nullptr;
  bool whole = line->positional.size() == 2;
  bool two = false;
  for (const OptionSetting& setting : line->settings) {
    if (setting.name == "within" || setting.name == "at-least") {
      two = two || (goal != nullptr && goal->name != setting.name);
      goal = &setting;
    }
    if (setting.name == "general.preset") preset = &setting.value;
    if (setting.name == "from" || setting.name == "to") whole = false;
  }
  RunGoal result;
  if (goal == nullptr) return result;
  const std::string option = "--" + goal->name;
  if (two) {
    return InvalidArgumentError("--within and --at-least do not go together");
  }
  const bool is_time = goal->name == "within";
  const StatusOr<double> value =
      is_time ? ParseDuration(goal->value) : ParsePsnrGoal(goal->value);
  if (!value.ok()) {
    return InvalidArgumentError(option + ": " + value.status().message());
  }
  (is_time ? result.seconds : result.psnr) = *value;
  if (!whole) {
    return InvalidArgumentError(
        option + " is for whole runs: run IMAGES WORKSPACE " + option + " " +
        goal->value + ", without --from and --to");
  }
  if (preset != nullptr && *preset != kAutoPreset) {
    return InvalidArgumentError(option + " goes with --preset auto, not with " +
                                *preset);
  }
  for (const OptionSetting& setting : line->settings) {
    if (result.psnr && IsChosenByPsnr(setting.name)) {
      return ChosenByPsnrError(setting.name);
    }
  }
  std::erase_if(line->settings, [](const OptionSetting& setting) {
    return setting.name == "within" || setting.name == "at-least" ||
           setting.name == "general.preset";
  });
  return result;
}

// Runs all stages with preset auto. The goal is given.
Status ExecuteWithGoal(const RunGoal& goal,
                       std::vector<OptionSetting> settings,
                       const RunRequest& request,
                       CommandContext& context) {
  // Over what config.ini says, and so not remembered.
  settings.push_back({"general.preset", kAutoPreset, "the goal of the run"});
  if (goal.seconds) {
    return ExecuteWithin(
        *goal.seconds, settings, request, context.err, context.cancellation);
  }
  return ExecuteAtLeast(
      *goal.psnr, settings, request, context.err, context.cancellation);
}

}  // namespace

CommandWords RunWords() { return KeepWords<RunWordsTargets>(DescribeRun); }

CommandWords StageWords() { return KeepWords<StageTargets>(DescribeStage); }

Status RunRunCommand(const std::vector<std::string>& arguments,
                     CommandContext& context) {
  RunWordsTargets targets;
  CommandWords command = DescribeRun(&targets);
  OptionTable& table = command.table();
  RunRequest request;
  FREEGS_ASSIGN_OR_RETURN(OptionTable::CommandLine line,
                          command.Parse(arguments));
  FREEGS_ASSIGN_OR_RETURN(const RunGoal goal, TakeGoal(&line));
  if (goal.given() && !targets.forget.empty()) {
    return InvalidArgumentError(
        "--within and --at-least keep no options of earlier commands; leave "
        "out --forget");
  }
  const std::vector<std::string>& words = line.positional;
  request.workspace = AbsoluteFolder(words.back());
  fs::path images;
  if (words.size() == 2) images = AbsoluteFolder(words.front());
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(request.workspace, {images}));
  std::optional<pipeline::WorkspaceLock> lock;
  const auto take_workspace = [&]() -> Status {
    FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.workspace));
    FREEGS_ASSIGN_OR_RETURN(
        lock, pipeline::WorkspaceLock::Acquire(request.workspace));
    return Status();
  };
  // Settings that another run stores must not be overwritten by older ones. A
  // folder without any is not taken yet: if the run is refused, nothing of it
  // is left there.
  std::error_code error;
  if (fs::exists(pipeline::WorkspaceInfoPath(request.workspace), error)) {
    FREEGS_RETURN_IF_ERROR(take_workspace());
  }
  FREEGS_ASSIGN_OR_RETURN(const WorkspaceInfo before,
                          pipeline::ReadWorkspaceInfo(request.workspace));
  FREEGS_RETURN_IF_ERROR(CheckGivenPaths(
      request.workspace, table, line.settings, before.settings));
  FREEGS_RETURN_IF_ERROR(Recall(before, targets, line, table, &request));
  FREEGS_RETURN_IF_ERROR(TakeImages(images, before.images, &request));
  RememberOptions(request.workspace, table, line.settings, &request.info);
  std::vector<OptionSetting> settings =
      RememberedSettings(request.workspace, request.info, table);
  settings.insert(settings.end(), line.settings.begin(), line.settings.end());
  if (!goal.given()) {
    FREEGS_RETURN_IF_ERROR(ApplySettings(request.workspace, settings, table));
  }
  request.from = targets.from;
  request.to = targets.to;
  FREEGS_RETURN_IF_ERROR(CheckOrder(request.from, request.to));
  if (!lock) FREEGS_RETURN_IF_ERROR(take_workspace());
  if (goal.given()) {
    FREEGS_RETURN_IF_ERROR(
        ExecuteWithGoal(goal, std::move(settings), request, context));
  } else {
    FREEGS_RETURN_IF_ERROR(
        pipeline::WriteWorkspaceInfo(request.workspace, request.info));
    FREEGS_RETURN_IF_ERROR(Execute(
        request, targets.options, table, context.err, context.cancellation));
  }
  if (request.to == StageNames().back()) {
    TellResult(request.workspace, words.back(), context.out);
  }
  return Status();
}

Status RunStageCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  StageTargets targets;
  CommandWords command = DescribeStage(&targets);
  OptionTable& table = command.table();
  FREEGS_ASSIGN_OR_RETURN(const OptionTable::CommandLine line,
                          command.Parse(arguments));
  RunRequest request;
  request.forced = line.positional[0];
  request.from = request.forced;
  request.to = request.forced;
  FREEGS_ASSIGN_OR_RETURN(request.workspace,
                          ExistingWorkspace(line.positional[1]));
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(request.workspace));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceLock lock,
                          pipeline::WorkspaceLock::Acquire(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(request.info,
                          pipeline::ReadWorkspaceInfo(request.workspace));
  FREEGS_RETURN_IF_ERROR(ForgetOptions(targets.forget, table, &request.info));
  const std::string others =
      OtherOptionsText(request.info.settings, line.settings);
  if (!others.empty()) {
    request.note = "stage: uses remembered options: " + others;
  }
  FREEGS_RETURN_IF_ERROR(CheckGivenPaths(
      request.workspace, table, line.settings, request.info.settings));
  RememberOptions(request.workspace, table, line.settings, &request.info);
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace,
                    RememberedSettings(request.workspace, request.info, table),
                    table));
  FREEGS_RETURN_IF_ERROR(
      pipeline::WriteWorkspaceInfo(request.workspace, request.info));
  return Execute(
      request, targets.options, table, context.err, context.cancellation);
}

}  // namespace freegs::stages
