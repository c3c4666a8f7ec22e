// SPDX-License-Identifier: BSD-3-Clause
// The file STAGE/stage.json, which tells how the output of a stage was made.

#ifndef FREEGS_PIPELINE_STAGE_RECORD_H_
#define FREEGS_PIPELINE_STAGE_RECORD_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "pipeline/fingerprint.h"
#include "pipeline/output_files.h"

namespace freegs::pipeline {

// Everything that decides the result of a stage. Two runs with equal
// fingerprints write the same output.
struct StageFingerprint {
  std::string stage;
  int version = 1;
  std::map<std::string, std::string> options;  // By name: "sfm.matcher".
  std::map<std::string, InputFingerprint> inputs;

  bool operator==(const StageFingerprint&) const = default;
};

// Says in a few words why a result with the fingerprint `then` does not hold
// for `now`: "option reconstruct.iterations changed 7000 -> 30000". Empty if
// the two are equal.
std::string Difference(const StageFingerprint& then,
                       const StageFingerprint& now);

enum class StageOutcome { kDone, kFailed, kInterrupted };

struct StageRecord {
  StageFingerprint fingerprint;
  StageOutcome outcome = StageOutcome::kDone;
  std::string program_version;

  // Options that do not change the result, for information.
  std::map<std::string, std::string> other_options;

  // Sums over all runs that led to this output, including interrupted ones. CPU
  // time counts all threads and child processes. The peak is the largest
  // resident memory of this process or of one of its children.
  double wall_seconds = 0;
  double cpu_seconds = 0;
  int64_t peak_memory_bytes = 0;

  // What the last run was expected to need at its peak, and for all of the
  // stage (Stage::Foretell); 0 when nothing was known.
  int64_t expected_memory_bytes = 0;
  double expected_seconds = 0;

  // Whether the last run continued an earlier, interrupted one.
  bool resumed = false;

  // Facts that the stage reports.
  nlohmann::json summary = nlohmann::json::object();

  // The files that later stages read.
  OutputFiles outputs;

  // The names of the files and folders directly in the stage's folder, without
  // those that nobody needs any more.
  std::vector<std::string> contents;

  // Why the stage failed; kOk if it did not.
  StatusCode error_code = StatusCode::kOk;
  std::string error;
};

nlohmann::json ToJson(const StageFingerprint& fingerprint);
nlohmann::json ToJson(const StageRecord& record);

// Return kBadInput when a field is missing or of the wrong type.
StatusOr<StageFingerprint> FingerprintFromJson(const nlohmann::json& json);
StatusOr<StageRecord> RecordFromJson(const nlohmann::json& json);

std::filesystem::path RecordPath(const std::filesystem::path& folder);

// Reads folder/stage.json. Returns kBadInput if it is missing or malformed.
StatusOr<StageRecord> ReadStageRecord(const std::filesystem::path& folder);
Status WriteStageRecord(const std::filesystem::path& folder,
                        const StageRecord& record);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_RECORD_H_
