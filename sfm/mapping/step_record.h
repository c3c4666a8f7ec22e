// SPDX-License-Identifier: BSD-3-Clause
// Which steps of structure from motion are finished, kept in a file so that a
// killed run goes on where it was.

#ifndef FREEGS_SFM_MAPPING_STEP_RECORD_H_
#define FREEGS_SFM_MAPPING_STEP_RECORD_H_

#include <filesystem>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "sfm/matching/pair_selection.h"

namespace freegs::sfm {

// steps.json in a work folder. A step is recorded after its files are complete;
// a step that is not recorded is done again. A file that cannot be understood
// counts as empty.
class StepRecord {
 public:
  explicit StepRecord(const std::filesystem::path& work_folder);

  bool Has(const std::string& step) const { return done_.contains(step); }
  const std::set<int>& portions() const { return portions_; }
  const MatchedPairs& pairs() const { return pairs_; }
  int image_size() const { return image_size_; }  // 0: none was chosen.

  Status Add(const std::string& step);
  // A portion of the matching.
  Status AddPortion(int portion);
  // The step "matches", and what was matched.
  Status AddMatches(const MatchedPairs& pairs);
  Status SetImageSize(int size);

 private:
  Status Save() const;

  std::filesystem::path path_;
  std::set<std::string> done_;
  std::set<int> portions_;
  MatchedPairs pairs_;
  int image_size_ = 0;
};

// For files. Null when nothing was matched; anything that cannot be understood
// counts as that.
nlohmann::json MatchedPairsToJson(const MatchedPairs& pairs);
MatchedPairs MatchedPairsFromJson(const nlohmann::json& json);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_STEP_RECORD_H_
