// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_record.h"

#include <array>
#include <climits>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::pipeline {
namespace {

using nlohmann::json;

constexpr int64_t kMaxCount = int64_t{1} << 62;
constexpr double kMaxSeconds = 1e18;

constexpr std::array<std::pair<StageOutcome, const char*>, 3> kOutcomes = {{
    {StageOutcome::kDone, "done"},
    {StageOutcome::kFailed, "failed"},
    {StageOutcome::kInterrupted, "interrupted"},
}};

constexpr std::array<std::pair<StatusCode, const char*>, 7> kCodes = {{
    {StatusCode::kOk, "ok"},
    {StatusCode::kInvalidArgument, "invalid argument"},
    {StatusCode::kBadInput, "bad input"},
    {StatusCode::kUnusableResult, "unusable result"},
    {StatusCode::kMissingDependency, "missing dependency"},
    {StatusCode::kInterrupted, "interrupted"},
    {StatusCode::kInternal, "internal"},
}};

template <typename Table, typename T>
const char* WordOf(const Table& table, T value) {
  for (const auto& [known, name] : table) {
    if (known == value) return name;
  }
  return "";
}

// The value whose name is the text of the member; the first of the table after
// a fault.
template <typename Table>
auto ValueOf(const Table& table, const char* key, JsonObjectReader& reader) {
  const std::string text = reader.Text(key);
  for (const auto& [known, name] : table) {
    if (text == name) return known;
  }
  reader.Fail(key, "is the unknown word '" + text + "'");
  return table[0].first;
}

// A fingerprint, which may be a part of a record.
StageFingerprint ReadFingerprint(const json& object, Status* status) {
  JsonObjectReader reader(object, "", "", status);
  StageFingerprint fingerprint;
  fingerprint.stage = reader.Text("stage");
  fingerprint.version = reader.Integer("version", INT_MIN, INT_MAX);
  fingerprint.options = reader.TextMap("options");
  for (const auto& [name, value] : reader.Object("inputs").items()) {
    JsonObjectReader input(value, "", "inputs." + name, status);
    fingerprint.inputs[name] = {
        .hash = input.Text("hash"),
        .files = input.Integer64("files", 0, kMaxCount),
        .path = input.Has("path") ? input.Text("path") : "",
        .from_workspace =
            input.Has("from_workspace") ? input.Text("from_workspace") : ""};
  }
  return fingerprint;
}

std::string Files(int64_t n) {
  return std::to_string(n) + (n == 1 ? " file" : " files");
}

}  // namespace

std::string Difference(const StageFingerprint& then,
                       const StageFingerprint& now) {
  if (then.stage != now.stage) return "made by stage " + then.stage;
  if (then.version != now.version) {
    return "this program's version of the stage is " +
           std::to_string(now.version) + ", the result's " +
           std::to_string(then.version);
  }
  for (const auto& [name, value] : now.options) {
    const auto old = then.options.find(name);
    if (old == then.options.end()) return "option " + name + " is new";
    if (old->second != value) {
      const auto shown = [](const std::string& text) {
        return text.empty() ? std::string("''") : text;
      };
      return "option " + name + " changed " + shown(old->second) + " -> " +
             shown(value);
    }
  }
  for (const auto& [name, value] : then.options) {
    if (!now.options.contains(name)) return "option " + name + " is gone";
  }
  for (const auto& [name, input] : now.inputs) {
    const auto old = then.inputs.find(name);
    const bool is_new = old == then.inputs.end();
    if (!is_new && old->second == input) continue;
    if (input.missing()) return "input " + name + " is missing";
    if (is_new) return "input " + name + " is new";
    std::string reason = "input " + name + " changed";
    if (old->second.files != input.files) {
      reason +=
          " (" + Files(old->second.files) + " -> " + Files(input.files) + ")";
    }
    return reason;
  }
  for (const auto& [name, input] : then.inputs) {
    if (!now.inputs.contains(name)) {
      return "input " + name + " is no longer used";
    }
  }
  return "";
}

json ToJson(const StageFingerprint& fingerprint) {
  json inputs = json::object();
  for (const auto& [name, input] : fingerprint.inputs) {
    inputs[name] = {{"hash", input.hash}, {"files", input.files}};
    if (!input.path.empty()) inputs[name]["path"] = input.path;
    if (!input.from_workspace.empty()) {
      inputs[name]["from_workspace"] = input.from_workspace;
    }
  }
  return {{"stage", fingerprint.stage},
          {"version", fingerprint.version},
          {"options", fingerprint.options},
          {"inputs", std::move(inputs)}};
}

json ToJson(const StageRecord& record) {
  json object = ToJson(record.fingerprint);
  object["status"] = WordOf(kOutcomes, record.outcome);
  object["program_version"] = record.program_version;
  object["other_options"] = record.other_options;
  object["wall_seconds"] = record.wall_seconds;
  object["cpu_seconds"] = record.cpu_seconds;
  object["peak_memory_bytes"] = record.peak_memory_bytes;
  object["expected_memory_bytes"] = record.expected_memory_bytes;
  object["expected_seconds"] = record.expected_seconds;
  object["resumed"] = record.resumed;
  object["summary"] = record.summary;
  object["outputs"] = record.outputs;
  object["contents"] = record.contents;
  if (record.error_code != StatusCode::kOk) {
    object["error"] = {{"code", WordOf(kCodes, record.error_code)},
                       {"message", record.error}};
  }
  return object;
}

StatusOr<StageFingerprint> FingerprintFromJson(const json& object) {
  Status status;
  StageFingerprint fingerprint = ReadFingerprint(object, &status);
  FREEGS_RETURN_IF_ERROR(status);
  return fingerprint;
}

StatusOr<StageRecord> RecordFromJson(const json& object) {
  Status status;
  StageRecord record;
  record.fingerprint = ReadFingerprint(object, &status);
  JsonObjectReader reader(object, "", "", &status);
  record.outcome = ValueOf(kOutcomes, "status", reader);
  record.program_version = reader.Text("program_version");
  record.other_options = reader.TextMap("other_options");
  record.wall_seconds = reader.Number("wall_seconds", 0, kMaxSeconds);
  record.cpu_seconds = reader.Number("cpu_seconds", 0, kMaxSeconds);
  record.peak_memory_bytes =
      reader.Integer64("peak_memory_bytes", 0, kMaxCount);
  // Records of older programs do not have them.
  if (reader.Has("expected_memory_bytes")) {
    record.expected_memory_bytes =
        reader.Integer64("expected_memory_bytes", 0, kMaxCount);
  }
  if (reader.Has("expected_seconds")) {
    record.expected_seconds = reader.Number("expected_seconds", 0, kMaxSeconds);
  }
  record.resumed = reader.Bool("resumed");
  record.summary = reader.Object("summary");
  if (reader.Has("outputs")) {
    JsonObjectReader outputs(reader.Object("outputs"), "", "outputs", &status);
    for (const auto& [name, size] : reader.Object("outputs").items()) {
      record.outputs[name] = outputs.Integer64(name.c_str(), 0, kMaxCount);
    }
  }
  if (reader.Has("contents")) record.contents = reader.TextList("contents");
  if (reader.Has("error")) {
    JsonObjectReader error(reader.Object("error"), "", "error", &status);
    record.error_code = ValueOf(kCodes, "code", error);
    record.error = error.Text("message");
  }
  FREEGS_RETURN_IF_ERROR(status);
  return record;
}

std::filesystem::path RecordPath(const std::filesystem::path& folder) {
  return folder / "stage.json";
}

StatusOr<StageRecord> ReadStageRecord(const std::filesystem::path& folder) {
  const std::filesystem::path path = RecordPath(folder);
  FREEGS_ASSIGN_OR_RETURN(const json object, ReadJson(path));
  StatusOr<StageRecord> record = RecordFromJson(object);
  if (!record.ok()) return record.status().Annotated(path.string());
  return record;
}

Status WriteStageRecord(const std::filesystem::path& folder,
                        const StageRecord& record) {
  return WriteFileAtomic(RecordPath(folder), JsonText(ToJson(record)));
}

}  // namespace freegs::pipeline
