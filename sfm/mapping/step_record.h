// SPDX-License-Identifier: BSD-3-Clause
// Remembers on disk which steps of structure from motion are finished, so that
// a killed run goes on where it was.

#ifndef FREEGS_SFM_MAPPING_STEP_RECORD_H_
#define FREEGS_SFM_MAPPING_STEP_RECORD_H_

#include <filesystem>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "sfm/matching/pair_selection.h"

namespace freegs::sfm {

// The file steps.json in a work folder. A step is recorded only after its files
// are complete; a step that is not recorded is done again.
//
//   StepRecord record(work_folder, colmap.version());
//   if (!record.Has("features")) {
//     ...  // Takes the features.
//     FREEGS_RETURN_IF_ERROR(record.Add("features"));
//   }
class StepRecord {
 public:
  // Reads the file. One that is missing or not understood counts as empty, and
  // so does one of another release of COLMAP: what follows could not be made
  // again from what it left.
  StepRecord(const std::filesystem::path& work_folder,
             std::string colmap_version);

  bool Has(const std::string& step) const { return done_.contains(step); }
  // Numbers of the finished portions of the matching.
  const std::set<int>& portions() const { return portions_; }
  // The pairs of photos that were matched; known once "matches" is finished.
  const MatchedPairs& pairs() const { return pairs_; }
  // The image size chosen for feature extraction, in pixels; 0 before that.
  int image_size() const { return image_size_; }

  // Each of these writes the file. They return the errors of writing.
  Status Add(const std::string& step);
  Status AddPortion(int portion);
  // Records the step "matches" together with what was matched.
  Status AddMatches(const MatchedPairs& pairs);
  Status SetImageSize(int size);

 private:
  Status Save() const;

  std::filesystem::path path_;
  std::string colmap_version_;
  std::set<std::string> done_;
  std::set<int> portions_;
  MatchedPairs pairs_;
  int image_size_ = 0;
};

// What was matched, as JSON and back. Null stands for "nothing was matched";
// MatchedPairsFromJson also reads anything that it does not understand as that.
nlohmann::json MatchedPairsToJson(const MatchedPairs& pairs);
MatchedPairs MatchedPairsFromJson(const nlohmann::json& json);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_STEP_RECORD_H_
