// SPDX-License-Identifier: BSD-3-Clause
// The record of finished steps.

#include "sfm/mapping/step_record.h"

#include "core/io/files.h"

namespace freegs::sfm {

StepRecord::StepRecord(const std::filesystem::path& work_folder)
    : path_(work_folder / "steps.json") {
  const StatusOr<std::string> text = ReadFile(path_, 1 << 20);
  if (!text.ok()) return;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object()) return;
  for (const auto& [key, values] : json.items()) {
    if (key == "pairs") pairs_ = MatchedPairsFromJson(values);
    if (key == "image_size" && values.is_number_integer()) {
      image_size_ = values.get<int>();
    }
    if (!values.is_array()) continue;
    for (const auto& value : values) {
      if (key == "done" && value.is_string()) done_.insert(value);
      if (key == "matched_portions" && value.is_number_integer()) {
        portions_.insert(value.get<int>());
      }
    }
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
  const nlohmann::json json = {{"done", done_},
                               {"matched_portions", portions_},
                               {"image_size", image_size_},
                               {"pairs", MatchedPairsToJson(pairs_)}};
  return WriteFileAtomic(path_, json.dump(2) + "\n");
}

nlohmann::json MatchedPairsToJson(const MatchedPairs& pairs) {
  if (pairs.strategy.empty()) return nullptr;
  return {{"strategy", pairs.strategy},
          {"pairs", pairs.pairs},
          {"all_pairs", pairs.all_pairs}};
}

MatchedPairs MatchedPairsFromJson(const nlohmann::json& json) {
  if (!json.is_object()) return {};
  const auto strategy = json.find("strategy");
  const auto pairs = json.find("pairs");
  const auto all_pairs = json.find("all_pairs");
  if (strategy == json.end() || !strategy->is_string() || pairs == json.end() ||
      !pairs->is_number_unsigned() || all_pairs == json.end() ||
      !all_pairs->is_number_unsigned()) {
    return {};
  }
  return {strategy->get<std::string>(),
          pairs->get<size_t>(),
          all_pairs->get<size_t>()};
}

}  // namespace freegs::sfm
