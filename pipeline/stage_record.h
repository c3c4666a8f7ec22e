// SPDX-License-Identifier: BSD-3-Clause
// STAGE/stage.json: how a stage's output came to be.

#ifndef FREEGS_PIPELINE_STAGE_RECORD_H_
#define FREEGS_PIPELINE_STAGE_RECORD_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "pipeline/fingerprint.h"

namespace freegs::pipeline {

// All that decides a stage's result. Two runs with equal fingerprints write the
// same output.
struct StageFingerprint {
  std::string stage;
  int version = 1;
  std::map<std::string, std::string> options;  // "reconstruct.iterations".
  std::map<std::string, InputFingerprint> inputs;

  bool operator==(const StageFingerprint&) const = default;
};

// Why a result made under `then` does not hold under `now`, in a few words:
// "option reconstruct.iterations changed 7000 -> 30000". Empty if they are
// equal.
std::string Difference(const StageFingerprint& then,
                       const StageFingerprint& now);

enum class StageOutcome { kDone, kFailed, kInterrupted };

struct StageRecord {
  StageFingerprint fingerprint;
  StageOutcome outcome = StageOutcome::kDone;
  std::string program_version;

  // Options that do not change the result, for the reader.
  std::map<std::string, std::string> other_options;

  // Over all runs that led to this output, interrupted ones included. The CPU
  // time is that of all threads and child processes; the peak is the largest
  // resident memory of this process or of one child.
  double wall_seconds = 0;
  double cpu_seconds = 0;
  int64_t peak_memory_bytes = 0;

  // Whether the last run continued an earlier, interrupted one.
  bool resumed = false;

  // What the stage wanted to be seen.
  nlohmann::json summary = nlohmann::json::object();

  // Why it failed.
  StatusCode error_code = StatusCode::kOk;
  std::string error;
};

nlohmann::json ToJson(const StageFingerprint& fingerprint);
nlohmann::json ToJson(const StageRecord& record);

// kBadInput when a field is missing or of the wrong type.
StatusOr<StageFingerprint> FingerprintFromJson(const nlohmann::json& json);
StatusOr<StageRecord> RecordFromJson(const nlohmann::json& json);

std::filesystem::path RecordPath(const std::filesystem::path& folder);

// folder/stage.json; kBadInput if it is missing or malformed.
StatusOr<StageRecord> ReadStageRecord(const std::filesystem::path& folder);
Status WriteStageRecord(const std::filesystem::path& folder,
                        const StageRecord& record);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_RECORD_H_
