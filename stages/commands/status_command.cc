// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/status_command.h"

#include <filesystem>
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
    if (value.is_structured() || value.is_null()) continue;
    // The stage's own time and memory are shown from the record.
    if (name.ends_with("seconds") || name.ends_with("_bytes")) continue;
    if (value.is_string() && value.get_ref<const std::string&>().size() > 40) {
      continue;
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

}  // namespace

Status RunStatusCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  bool as_json = false;
  table.Add("json", &as_json, {.help = "For programs."});
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  if (line.positional.size() != 1) {
    return InvalidArgumentError(
        "status takes one workspace: status WORKSPACE [--json]");
  }
  std::error_code error;
  const fs::path workspace =
      fs::absolute(line.positional[0], error).lexically_normal();
  if (!fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": no such workspace");
  }
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceInfo info,
                          pipeline::ReadWorkspaceInfo(workspace));
  std::vector<pipeline::OptionSetting> settings =
      RememberedSettings(workspace, info, table);
  settings.insert(settings.end(), line.settings.begin(), line.settings.end());
  FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, settings, table));

  pipeline::Logger logger(context.err, /*terminal=*/false, "");
  pipeline::StageRunnerOptions runner_options;
  runner_options.workspace = workspace;
  runner_options.images = info.images;
  pipeline::StageRunner runner(MakeStages(options, table),
                               std::move(runner_options),
                               context.cancellation,
                               logger);
  const bool running = pipeline::IsLocked(workspace);
  if (!running) {
    // Completes what a killed run has left half done.
    const auto lock = pipeline::WorkspaceLock::Acquire(workspace);
    if (lock.ok()) (void)runner.Recover();
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<StageReport> reports,
                          runner.Inspect());

  if (as_json) {
    json stages = json::array();
    for (const StageReport& report : reports) {
      stages.push_back(ReportJson(report, running));
    }
    context.out << JsonText({{"workspace", workspace.string()},
                             {"photos", info.images.string()},
                             {"running", running},
                             {"stages", std::move(stages)}});
    return Status();
  }
  context.out << "workspace " << workspace.string()
              << (running ? " (a run is working here)" : "") << "\n";
  if (!info.images.empty()) {
    context.out << "photos    " << info.images.string() << "\n";
  }
  for (const StageReport& report : reports) {
    PrintReport(report, running, context.out);
  }
  return Status();
}

}  // namespace freegs::stages
