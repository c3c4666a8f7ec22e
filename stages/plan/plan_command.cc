// SPDX-License-Identifier: BSD-3-Clause

#include "stages/plan/plan_command.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "core/number_text.h"
#include "pipeline/forecast/stage_need.h"
#include "pipeline/logger.h"
#include "pipeline/stage_runner.h"
#include "pipeline/system_info.h"
#include "pipeline/version.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"
#include "stages/run/workspace_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::StageForecast;

struct PlanTargets {
  PipelineOptions options;
  std::string images;
  bool json = false;
};

CommandWords DescribePlan(PlanTargets* targets) {
  CommandWords words("plan",
                     "Foretells the time, memory and disk space of each stage, "
                     "without running any.",
                     MakeOptionTable(&targets->options));
  words.AddArgument(WorkspaceArgument());
  words.AddOption("images",
                  &targets->images,
                  {.help = "Folder of the photos; then the workspace need not "
                           "exist, and remembered options do not hold.",
                   .value_name = "IMAGES"});
  words.AddOption("json", &targets->json, {.help = "Print JSON."});
  words.ReferToOptionsOf("run");
  words.AddNote(
      "The plan is that of freegs_pipeline run IMAGES WORKSPACE with these "
      "options or, without --images, of freegs_pipeline run WORKSPACE.");
  return words;
}

// remembered: the folder that the workspace was made of; may be empty.
Status CheckFolders(const fs::path& workspace,
                    const fs::path& images,
                    const fs::path& remembered) {
  std::error_code error;
  if (images.empty()) {
    return fs::is_directory(workspace, error)
               ? InvalidArgumentError(workspace.string() +
                                      ": does not know its photos yet; give "
                                      "--images IMAGES")
               : BadInputError(workspace.string() +
                               ": no such workspace; for the plan of a new one "
                               "give --images IMAGES");
  }
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(workspace, {images}));
  return CheckImagesFolder(images, remembered, workspace);
}

json PlanJson(const fs::path& workspace,
              int threads,
              const std::vector<StageForecast>& stages) {
  json list = json::array();
  for (const auto& [stage, needed, reason, need, begun] : stages) {
    list.push_back(
        {{"name", stage},
         {"state", needed ? "needed" : "up_to_date"},
         {"reason", reason},
         {"threads", threads},
         {"seconds", need.seconds},
         {"memory_bytes", need.memory_bytes},
         {"disk_bytes", need.disk_bytes},
         {"known", need.known()},
         {"from_files", need.from_files},
         {"advice", need.known() ? need.advice : need.unknown_reason}});
  }
  const pipeline::StageNeed sum = Total(stages).sum;
  return {{"workspace", workspace.string()},
          {"program", pipeline::kProgramVersion},
          {"threads", threads},
          {"stages", std::move(list)},
          {"total",
           {{"seconds", sum.seconds},
            {"memory_bytes", sum.memory_bytes},
            {"disk_bytes", sum.disk_bytes}}}};
}

std::string PlanTable(const std::vector<StageForecast>& stages) {
  std::ostringstream text;
  const auto column = [&text](std::string word, size_t width) {
    word.resize(std::max(width, word.size()), ' ');
    text << word << "  ";
  };
  const auto row = [&](const std::string& name,
                       const std::string& seconds,
                       const std::string& memory,
                       const std::string& disk) {
    column(name, 11);
    column(seconds, 11);
    column(memory, 8);
    column(disk, 8);
  };
  row("stage", "time", "memory", "disk");
  text << "state\n";
  for (const auto& [stage, needed, reason, need, begun] : stages) {
    const auto bytes = [](int64_t n) {
      return FormatBytes(static_cast<double>(n));
    };
    if (need.known()) {
      row(stage,
          FormatSeconds(need.seconds),
          bytes(need.memory_bytes),
          bytes(need.disk_bytes));
    } else {
      row(stage, "not known", "", "");
    }
    text << (needed ? reason
                    : "up to date" + (reason.empty() ? "" : ": " + reason));
    if (!need.unknown_reason.empty()) text << "; " << need.unknown_reason;
    text << "\n";
  }
  const std::string total = RunNeedText(Total(stages));
  text << "run: " << (total.empty() ? "everything is up to date" : total)
       << "\n";
  return text.str();
}

}  // namespace

CommandWords PlanWords() { return KeepWords<PlanTargets>(DescribePlan); }

Status RunPlan(const std::vector<std::string>& arguments,
               std::ostream& out,
               const CancellationToken& cancellation) {
  PlanTargets targets;
  CommandWords words = DescribePlan(&targets);
  pipeline::OptionTable& table = words.table();
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  const fs::path workspace = AbsoluteFolder(line.positional[0]);
  FREEGS_ASSIGN_OR_RETURN(pipeline::WorkspaceInfo info,
                          pipeline::ReadWorkspaceInfo(workspace));
  const fs::path remembered_images = info.images;
  std::vector<pipeline::OptionSetting> settings = line.settings;
  for (const pipeline::OptionSetting& setting : line.settings) {
    if (setting.name == "images") info = {AbsoluteFolder(setting.value), {}};
  }
  FREEGS_RETURN_IF_ERROR(
      CheckFolders(workspace, info.images, remembered_images));
  const auto remembered = RememberedSettings(workspace, info, table);
  settings.insert(settings.begin(), remembered.begin(), remembered.end());
  FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, settings, table));

  std::ostringstream ignored;
  pipeline::Logger logger(ignored, /*terminal=*/false, "");
  pipeline::StageRunnerOptions runner_options;
  runner_options.workspace = workspace;
  runner_options.images = info.images;
  runner_options.num_threads = targets.options.general.threads;
  pipeline::StageRunner runner(MakeStages(targets.options, table),
                               std::move(runner_options),
                               cancellation,
                               logger);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<StageForecast> stages,
                          runner.Forecast());
  if (targets.json) {
    out << JsonText(
        PlanJson(workspace,
                 pipeline::WorkingThreads(targets.options.general.threads),
                 stages));
  } else {
    out << PlanTable(stages);
  }
  return Status();
}

}  // namespace freegs::stages
