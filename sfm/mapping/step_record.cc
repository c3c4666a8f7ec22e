// SPDX-License-Identifier: BSD-3-Clause
// The record of finished steps.

#include "sfm/mapping/step_record.h"

#include <climits>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::sfm {

StepRecord::StepRecord(const std::filesystem::path& work_folder,
                       std::string colmap_version)
    : path_(work_folder / "steps.json"),
      colmap_version_(std::move(colmap_version)) {
  const StatusOr<std::string> text = ReadFile(path_, 1 << 20);
  if (!text.ok()) return;
  const auto json = ParseJson(*text);
  if (!json.ok()) return;
  const auto version = ReadText(FindField(*json, "colmap"), "");
  if (!version.ok() || *version != colmap_version_) return;
  if (const auto* pairs = FindField(*json, "pairs")) {
    pairs_ = MatchedPairsFromJson(*pairs);
  }
  const auto size = ReadInteger(FindField(*json, "image_size"), 0, INT_MAX, "");
  if (size.ok()) image_size_ = *size;
  if (const auto* done = FindField(*json, "done"); done && done->is_array()) {
    for (const auto& value : *done) {
      if (value.is_string()) done_.insert(value);
    }
  }
  const auto* portions = FindField(*json, "matched_portions");
  if (portions == nullptr || !portions->is_array()) return;
  for (const auto& value : *portions) {
    const auto portion = ReadInteger(&value, 0, INT_MAX, "");
    if (portion.ok()) portions_.insert(*portion);
  }
}

Status StepRecord::Add(const std::string& step) {
  done_.insert(step);
  return Save();
}

Status StepRecord::AddPortion(int portion) {
  portions_.insert(portion);
  return Save();
}

Status StepRecord::AddMatches(const MatchedPairs& pairs) {
  pairs_ = pairs;
  return Add("matches");
}

Status StepRecord::SetImageSize(int size) {
  image_size_ = size;
  return Save();
}

Status StepRecord::Save() const {
  const nlohmann::json json = {{"colmap", colmap_version_},
                               {"done", done_},
                               {"matched_portions", portions_},
                               {"image_size", image_size_},
                               {"pairs", MatchedPairsToJson(pairs_)}};
  // COLMAP does not wait until its database is on disk; but a step must not
  // count as done before its results are.
  for (const char* name : {"database.db", "database.db-wal"}) {
    FREEGS_RETURN_IF_ERROR(FlushToDisk(path_.parent_path() / name));
  }
  return WriteFileAtomic(path_, JsonText(json));
}

nlohmann::json MatchedPairsToJson(const MatchedPairs& pairs) {
  if (pairs.strategy.empty()) return nullptr;
  return {{"strategy", pairs.strategy},
          {"pairs", pairs.pairs},
          {"all_pairs", pairs.all_pairs}};
}

MatchedPairs MatchedPairsFromJson(const nlohmann::json& json) {
  Status status;
  JsonObjectReader reader(json, "", "pairs", &status);
  MatchedPairs pairs;
  constexpr int64_t kMaxPairs = int64_t{1} << 52;
  pairs.strategy = reader.Text("strategy");
  pairs.pairs = static_cast<size_t>(reader.Integer64("pairs", 0, kMaxPairs));
  pairs.all_pairs =
      static_cast<size_t>(reader.Integer64("all_pairs", 0, kMaxPairs));
  return status.ok() ? pairs : MatchedPairs();
}

}  // namespace freegs::sfm
