// SPDX-License-Identifier: BSD-3-Clause
// The record of finished steps.

#include "sfm/step_record.h"

#include <nlohmann/json.hpp>

#include "core/files.h"

namespace freegs::sfm {

StepRecord::StepRecord(const std::filesystem::path& work_folder)
    : path_(work_folder / "steps.json") {
  const StatusOr<std::string> text = ReadFile(path_, 1 << 20);
  if (!text.ok()) return;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object()) return;
  for (const auto& [key, values] : json.items()) {
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

Status StepRecord::Save() const {
  const nlohmann::json json = {{"done", done_},
                               {"matched_portions", portions_}};
  return WriteFileAtomic(path_, json.dump(2) + "\n");
}

}  // namespace freegs::sfm
