// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/status_command.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "core/number_text.h"
#include "pipeline/logger.h"
#include "pipeline/progress_line.h"
#include "pipeline/stage_runner.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"
#include "stages/run/workspace_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::StageRecord;
using pipeline::StageReport;
using pipeline::StageState;
using pipeline::StageStatus;

// The name of the status. An interrupted stage is called "running" while a run
// holds the workspace.
std::string StatusName(const StageState& state, bool running) {
  if (running && state.status == StageStatus::kInterrupted) return "running";
  return pipeline::StageStatusName(state.status);
}

// The record that describes the stage as it is now: that of its result, or that
// of the attempt that failed.
const StageRecord* RecordOf(const StageState& state) {
  if (state.status == StageStatus::kFailed && state.attempt) {
    return &*state.attempt;
  }
  return state.result ? &*state.result : nullptr;
}

json ReportJson(const StageReport& report, bool running) {
  json object = {{"stage", report.stage},
                 {"status", StatusName(report.state, running)},
                 {"reason", report.state.reason},
                 {"note", report.state.note},
                 {"resumable", report.state.resumable}};
  if (const StageRecord* record = RecordOf(report.state)) {
    object["wall_seconds"] = record->wall_seconds;
    object["cpu_seconds"] = record->cpu_seconds;
    object["peak_memory_bytes"] = record->peak_memory_bytes;
    object["expected_memory_bytes"] = record->expected_memory_bytes;
    object["expected_seconds"] = record->expected_seconds;
    object["summary"] = record->summary;
    const json full = pipeline::ToJson(*record);
    if (full.contains("error")) object["error"] = full["error"];
  }
  return object;
}

// The numbers and short texts of a summary, as "registered 50, verdict good".
std::string SummaryText(const json& summary) {
  constexpr int kMaxFacts = 6;
  std::ostringstream text;
  int facts = 0;
  for (const auto& [name, value] : summary.items()) {
    // A list of photos, of which the number is told.
    if (name == "rejected" && value.is_array() && !value.empty()) {
      if (++facts > kMaxFacts) break;
      text << (facts > 1 ? ", " : "") << name << " " << value.size();
      continue;
    }
    if (value.is_structured() || value.is_null()) continue;
    // The stage's own time and memory are shown from the record.
    if (name.ends_with("seconds") || name.ends_with("_bytes")) continue;
    if (value.is_string()) {
      const auto length = value.get_ref<const std::string&>().size();
      if (length == 0 || length > 40) continue;
    }
    if (++facts > kMaxFacts) break;
    text << (facts > 1 ? ", " : "") << name << " ";
    if (value.is_string()) {
      text << value.get<std::string>();
    } else if (value.is_number_float()) {
      text << FormatSignificant(value.get<double>(), 6);
    } else if (value.is_boolean()) {
      text << (value.get<bool>() ? "true" : "false");
    } else {
      text << value.get<int64_t>();
    }
  }
  return text.str();
}

// An option that is not only in the program's defaults or a preset.
struct StoredOption {
  std::string name;
  std::string value;
  std::string source;  // "workspace.json" or "config.ini".
  std::optional<std::string> default_value;  // None where it is unknown.
  bool changed = false;  // Whether the value differs from the default.
};

// What the workspace remembers from earlier commands, then what config.ini sets
// beside it.
StatusOr<std::vector<StoredOption>> StoredOptions(
    const fs::path& workspace, const pipeline::WorkspaceInfo& info) {
  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  std::vector<pipeline::OptionSetting> settings;
  for (const auto& [name, value] : info.settings) {
    settings.push_back({name, value, "workspace.json"});
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<pipeline::OptionSetting> config,
                          ConfigSettings(workspace, table));
  for (const pipeline::OptionSetting& setting : config) {
    if (info.settings.contains(setting.name)) continue;
    settings.push_back({setting.name, setting.value, "config.ini"});
  }
  std::vector<StoredOption> stored;
  for (const pipeline::OptionSetting& setting : settings) {
    StoredOption option{
        setting.name, setting.value, setting.source, std::nullopt, false};
    if (const pipeline::OptionTable::Option* known = table.Find(option.name)) {
      option.default_value = known->default_value;
      // Compared as the table writes it: 1e3 is 1000.
      option.changed = !table.Apply({setting}).ok() ||
                       known->value() != known->default_value;
    }
    stored.push_back(std::move(option));
  }
  return stored;
}

json OptionJson(const StoredOption& option) {
  return {{"name", option.name},
          {"value", option.value},
          {"source", option.source},
          {"default",
           option.default_value ? json(*option.default_value) : json(nullptr)},
          {"changed", option.changed}};
}

// Lists the options of one source, those that differ from the default with a
// star.
void PrintOptions(const std::vector<StoredOption>& options,
                  const std::string& source,
                  const std::string& title,
                  std::ostream& out) {
  const auto shown = [](const std::string& text) {
    // "none" is a value of some options.
    return text.empty() ? std::string("empty") : text;
  };
  bool first = true;
  for (const StoredOption& option : options) {
    if (option.source != source) continue;
    if (std::exchange(first, false)) out << title << "\n";
    out << (option.changed ? "* " : "  ") << option.name << " "
        << shown(option.value);
    if (!option.default_value) {
      out << "  (this program has no such option)";
    } else if (option.changed) {
      out << "  (default " << shown(*option.default_value) << ")";
    } else {
      out << "  (the default)";
    }
    out << "\n";
  }
}

void PrintReport(const StageReport& report, bool running, std::ostream& out) {
  const auto column = [](std::string text, size_t width) {
    text.resize(std::max(width, text.size()), ' ');
    return text + " ";
  };
  const StageState& state = report.state;
  const StageRecord* record = RecordOf(state);
  out << column(report.stage, 11) << column(StatusName(state, running), 11)
      << column(record ? FormatSeconds(record->wall_seconds) : "", 11);
  const bool is_running = running && state.status == StageStatus::kInterrupted;
  const std::string facts = record && state.status == StageStatus::kDone
                                ? SummaryText(record->summary)
                                : (is_running ? "" : state.reason);
  out << facts << "\n";
  if (!state.note.empty()) out << column("", 30) << state.note << "\n";
}

// What the command tells of a workspace.
struct WorkspaceStatus {
  fs::path workspace;
  fs::path photos;       // Empty where they are not known.
  bool running = false;  // Whether a run holds the workspace.
  std::vector<StoredOption> options;
  std::vector<StageReport> stages;
};

json StatusJson(const WorkspaceStatus& status) {
  json options = json::array();
  for (const StoredOption& option : status.options) {
    options.push_back(OptionJson(option));
  }
  json stages = json::array();
  for (const StageReport& report : status.stages) {
    stages.push_back(ReportJson(report, status.running));
  }
  return {{"workspace", status.workspace.string()},
          {"photos", status.photos.string()},
          {"running", status.running},
          {"options", std::move(options)},
          {"stages", std::move(stages)}};
}

void PrintStatus(const WorkspaceStatus& status, std::ostream& out) {
  out << "workspace " << status.workspace.string()
      << (status.running ? " (a run is working here)" : "") << "\n";
  if (!status.photos.empty()) {
    out << "photos    " << status.photos.string() << "\n";
  }
  for (const StageReport& report : status.stages) {
    PrintReport(report, status.running, out);
  }
  PrintOptions(
      status.options,
      "workspace.json",
      "remembered (* not the default; run WORKSPACE --forget KEY drops "
      "one):",
      out);
  PrintOptions(status.options,
               "config.ini",
               "set in config.ini (* not the default):",
               out);
}

struct StatusTargets {
  PipelineOptions options;
  bool json = false;
};

CommandWords DescribeStatus(StatusTargets* targets) {
  CommandWords words("status",
                     "Says what is done, what is stale and why, and which "
                     "options the workspace remembers.",
                     MakeOptionTable(&targets->options));
  words.AddArgument(WorkspaceArgument());
  words.AddOption("json", &targets->json, {.help = "Print JSON."});
  words.ReferToOptionsOf("run");
  words.AddNote(
      "The state of the stages is what freegs_pipeline run WORKSPACE would "
      "find with these options and the remembered ones. A remembered option "
      "is dropped by freegs_pipeline run WORKSPACE --forget KEY.");
  return words;
}

// Whether a run has left something behind. It may have been killed while it put
// a result in its place, which only somebody with the lock may complete. A
// folder without leftovers is not locked, because that writes a file into it.
bool HasLeftovers(const std::filesystem::path& workspace) {
  const std::vector<std::string> stages = StageNames();
  return std::any_of(
      stages.begin(), stages.end(), [&](const std::string& stage) {
        std::error_code error;
        return std::filesystem::exists(
                   pipeline::PartialFolder(workspace, stage), error) ||
               std::filesystem::exists(
                   pipeline::RetiredFolder(workspace, stage), error);
      });
}

}  // namespace

CommandWords StatusWords() { return KeepWords<StatusTargets>(DescribeStatus); }

Status RunStatusCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  StatusTargets targets;
  CommandWords words = DescribeStatus(&targets);
  pipeline::OptionTable& table = words.table();
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_ASSIGN_OR_RETURN(const fs::path workspace,
                          ExistingWorkspace(line.positional[0]));
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(workspace));
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceInfo info,
                          pipeline::ReadWorkspaceInfo(workspace));
  std::vector<pipeline::OptionSetting> settings =
      RememberedSettings(workspace, info, table);
  settings.insert(settings.end(), line.settings.begin(), line.settings.end());
  FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, settings, table));
  FREEGS_ASSIGN_OR_RETURN(std::vector<StoredOption> stored,
                          StoredOptions(workspace, info));

  pipeline::Logger logger(context.err, /*terminal=*/false, "");
  pipeline::StageRunnerOptions runner_options;
  runner_options.workspace = workspace;
  runner_options.images = info.images;
  pipeline::StageRunner runner(MakeStages(targets.options, table),
                               std::move(runner_options),
                               context.cancellation,
                               logger);
  const bool running = pipeline::IsLocked(workspace);
  if (!running && HasLeftovers(workspace)) {
    // Completes what a killed run has left half done.
    const auto lock = pipeline::WorkspaceLock::Acquire(workspace);
    if (lock.ok()) (void)runner.Recover();
  }
  const WorkspaceStatus status = {.workspace = workspace,
                                  .photos = info.images,
                                  .running = running,
                                  .options = std::move(stored),
                                  .stages = runner.Inspect()};
  if (context.cancellation.cancelled()) {
    return InterruptedError("interrupted while reading the inputs");
  }
  if (targets.json) {
    context.out << JsonText(StatusJson(status));
  } else {
    PrintStatus(status, context.out);
  }
  return Status();
}

}  // namespace freegs::stages
