// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/cell_result.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "core/text.h"
#include "pipeline/stage_record.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Objects within objects to this depth give figures "a.b".
constexpr int kMaxDepth = 3;

// Adds all numbers of an object as PREFIX + KEY. Lists are left out.
void AddNumbers(const json& object,
                const std::string& prefix,
                int depth,
                std::map<std::string, double>* values) {
  if (!object.is_object() || depth > kMaxDepth) return;
  for (const auto& [key, value] : object.items()) {
    if (value.is_boolean()) {
      (*values)[prefix + key] = value.get<bool>() ? 1 : 0;
    } else if (value.is_number()) {
      const double number = value.get<double>();
      if (std::isfinite(number)) (*values)[prefix + key] = number;
    } else if (value.is_object()) {
      AddNumbers(value, prefix + key + ".", depth + 1, values);
    }
  }
}

// The bytes of all files below a folder; links are not followed.
double FolderBytes(const fs::path& folder) {
  double bytes = 0;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator();
       entry.increment(error)) {
    std::error_code unknown;
    if (!entry->is_regular_file(unknown) || entry->is_symlink(unknown)) {
      continue;
    }
    const auto size = entry->file_size(unknown);
    if (!unknown) bytes += static_cast<double>(size);
  }
  return bytes;
}

void AddTotal(const std::string& name, double value, CellResult* result) {
  result->values["total." + name] += value;
}

}  // namespace

const char* CellStatusName(CellStatus status) {
  switch (status) {
    case CellStatus::kWaiting:
      return "waiting";
    case CellStatus::kDone:
      return "done";
    case CellStatus::kFailed:
      return "failed";
  }
  return "";
}

void AddStageFigures(const fs::path& workspace,
                     const std::string& stage,
                     CellResult* result) {
  std::error_code error;
  fs::path folder = workspace / stage;
  if (!fs::exists(folder, error)) folder = workspace / (stage + ".partial");
  std::map<std::string, double>& values = result->values;
  const std::string prefix = stage + ".";
  const StatusOr<json> metrics = ReadJson(folder / "metrics.json");
  if (metrics.ok()) AddNumbers(*metrics, prefix, 1, &values);
  const double bytes = FolderBytes(folder);
  values[prefix + "bytes"] = bytes;
  AddTotal("bytes", bytes, result);
  const auto scene = fs::file_size(folder / "point_cloud.ply", error);
  if (!error) values["scene_bytes"] = static_cast<double>(scene);

  const StatusOr<pipeline::StageRecord> record =
      pipeline::ReadStageRecord(folder);
  if (!record.ok()) {
    // Without the time of this stage, that of all is not known.
    values.erase("total.wall_seconds");
    values.erase("total.cpu_seconds");
    return;
  }
  AddNumbers(record->summary, prefix, 1, &values);
  const json* verdict = FindField(record->summary, "verdict");
  if (verdict != nullptr && verdict->is_string()) {
    result->verdict = verdict->get<std::string>();
  }
  const auto peak = static_cast<double>(record->peak_memory_bytes);
  values[prefix + "wall_seconds"] = record->wall_seconds;
  values[prefix + "cpu_seconds"] = record->cpu_seconds;
  values[prefix + "peak_memory_bytes"] = peak;
  AddTotal("wall_seconds", record->wall_seconds, result);
  AddTotal("cpu_seconds", record->cpu_seconds, result);
  double& total_peak = values["total.peak_memory_bytes"];
  total_peak = std::max(total_peak, peak);
}

Status AddEvaluation(const fs::path& file, CellResult* result) {
  FREEGS_ASSIGN_OR_RETURN(const json evaluation, ReadJson(file));
  AddNumbers(evaluation, "", kMaxDepth, &result->values);
  return Status();
}

std::string EndedText(const CellResult& result) {
  if (result.status != CellStatus::kFailed)
    return CellStatusName(result.status);
  return result.failed_stage + ": exit code " +
         std::to_string(result.exit_code);
}

json ToJson(const Suite& suite,
            const SuiteCell& cell,
            const CellResult& result) {
  json point = json::object();
  for (const auto& [key, value] : cell.point) point[key] = ValidUtf8(value);
  std::vector<std::string> said;
  for (const SaidLine& line : result.said) said.push_back(ValidUtf8(line.text));
  const std::vector<std::string> programs(result.programs.begin(),
                                          result.programs.end());
  return {{"id", ValidUtf8(cell.id)},
          {"scene", suite.scenes[cell.scene].name},
          {"grid", cell.grid},
          {"seed", cell.seed},
          {"point", std::move(point)},
          {"status", CellStatusName(result.status)},
          {"exit_code", result.exit_code},
          {"failed_stage", result.failed_stage},
          {"reason", ValidUtf8(result.reason)},
          {"verdict", ValidUtf8(result.verdict)},
          {"said", std::move(said)},
          {"ended", EndedText(result)},
          {"noticed", result.told.stage},
          {"told", ValidUtf8(result.told.text)},
          {"values", result.values},
          {"folder", result.folder},
          {"log", result.log},
          {"program", Joined(programs)}};
}

std::string KeyText(const Suite& suite,
                    const SuiteCell& cell,
                    const std::string& key) {
  if (key == "scene") return suite.scenes[cell.scene].name;
  if (key == "grid") return cell.grid;
  if (key == "seed") return std::to_string(cell.seed);
  for (const auto& [name, value] : cell.point) {
    if (name == key) return value;
  }
  return "";
}

}  // namespace freegs::stages
