// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_record.h"

#include <array>
#include <utility>

#include "core/io/files.h"
#include "pipeline/json_text.h"

namespace freegs::pipeline {
namespace {

using nlohmann::json;

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
const char* NameOf(const Table& table, T value) {
  for (const auto& [known, name] : table) {
    if (known == value) return name;
  }
  return "";
}

template <typename T, typename Table>
StatusOr<T> ValueOf(const Table& table, const std::string& text) {
  for (const auto& [known, name] : table) {
    if (text == name) return known;
  }
  return BadInputError("unknown word '" + text + "'");
}

// json[key] if it is there and of type T.
template <typename T>
StatusOr<T> Field(const json& object, const char* key) {
  const Status wrong =
      BadInputError(std::string("no valid field '") + key + "'");
  if (!object.is_object()) return wrong;
  const auto found = object.find(key);
  if (found == object.end()) return wrong;
  if constexpr (std::is_same_v<T, std::string>) {
    if (!found->is_string()) return wrong;
  } else if constexpr (std::is_same_v<T, bool>) {
    if (!found->is_boolean()) return wrong;
  } else if constexpr (std::is_same_v<T, json>) {
    if (!found->is_object()) return wrong;
  } else if constexpr (std::is_integral_v<T>) {
    if (!found->is_number_integer()) return wrong;
  } else {
    if (!found->is_number()) return wrong;
  }
  return found->get<T>();
}

StatusOr<std::map<std::string, std::string>> TextMap(const json& object,
                                                     const char* key) {
  FREEGS_ASSIGN_OR_RETURN(const json map, Field<json>(object, key));
  std::map<std::string, std::string> result;
  for (const auto& [name, value] : map.items()) {
    if (!value.is_string()) {
      return BadInputError("no valid field '" + name + "'");
    }
    result[name] = value.get<std::string>();
  }
  return result;
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
    if (old == then.inputs.end()) return "input " + name + " is new";
    if (old->second == input) continue;
    if (input.missing()) return "input " + name + " is missing";
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
  }
  return {{"stage", fingerprint.stage},
          {"version", fingerprint.version},
          {"options", fingerprint.options},
          {"inputs", std::move(inputs)}};
}

json ToJson(const StageRecord& record) {
  json object = ToJson(record.fingerprint);
  object["status"] = NameOf(kOutcomes, record.outcome);
  object["program_version"] = record.program_version;
  object["other_options"] = record.other_options;
  object["wall_seconds"] = record.wall_seconds;
  object["cpu_seconds"] = record.cpu_seconds;
  object["peak_memory_bytes"] = record.peak_memory_bytes;
  object["resumed"] = record.resumed;
  object["summary"] = record.summary;
  if (record.error_code != StatusCode::kOk) {
    object["error"] = {{"code", NameOf(kCodes, record.error_code)},
                       {"message", record.error}};
  }
  return object;
}

StatusOr<StageFingerprint> FingerprintFromJson(const json& object) {
  StageFingerprint fingerprint;
  FREEGS_ASSIGN_OR_RETURN(fingerprint.stage,
                          Field<std::string>(object, "stage"));
  FREEGS_ASSIGN_OR_RETURN(fingerprint.version, Field<int>(object, "version"));
  FREEGS_ASSIGN_OR_RETURN(fingerprint.options, TextMap(object, "options"));
  FREEGS_ASSIGN_OR_RETURN(const json inputs, Field<json>(object, "inputs"));
  for (const auto& [name, value] : inputs.items()) {
    InputFingerprint& input = fingerprint.inputs[name];
    FREEGS_ASSIGN_OR_RETURN(input.hash, Field<std::string>(value, "hash"));
    FREEGS_ASSIGN_OR_RETURN(input.files, Field<int64_t>(value, "files"));
  }
  return fingerprint;
}

StatusOr<StageRecord> RecordFromJson(const json& object) {
  StageRecord record;
  FREEGS_ASSIGN_OR_RETURN(record.fingerprint, FingerprintFromJson(object));
  FREEGS_ASSIGN_OR_RETURN(const std::string status,
                          Field<std::string>(object, "status"));
  FREEGS_ASSIGN_OR_RETURN(record.outcome,
                          ValueOf<StageOutcome>(kOutcomes, status));
  FREEGS_ASSIGN_OR_RETURN(record.program_version,
                          Field<std::string>(object, "program_version"));
  FREEGS_ASSIGN_OR_RETURN(record.other_options,
                          TextMap(object, "other_options"));
  FREEGS_ASSIGN_OR_RETURN(record.wall_seconds,
                          Field<double>(object, "wall_seconds"));
  FREEGS_ASSIGN_OR_RETURN(record.cpu_seconds,
                          Field<double>(object, "cpu_seconds"));
  FREEGS_ASSIGN_OR_RETURN(record.peak_memory_bytes,
                          Field<int64_t>(object, "peak_memory_bytes"));
  FREEGS_ASSIGN_OR_RETURN(record.resumed, Field<bool>(object, "resumed"));
  FREEGS_ASSIGN_OR_RETURN(record.summary, Field<json>(object, "summary"));
  if (object.contains("error")) {
    const json& error = object["error"];
    FREEGS_ASSIGN_OR_RETURN(const std::string code,
                            Field<std::string>(error, "code"));
    FREEGS_ASSIGN_OR_RETURN(record.error_code,
                            ValueOf<StatusCode>(kCodes, code));
    FREEGS_ASSIGN_OR_RETURN(record.error, Field<std::string>(error, "message"));
  }
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
