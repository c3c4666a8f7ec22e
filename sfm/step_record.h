// SPDX-License-Identifier: BSD-3-Clause
// Which steps of structure from motion are finished, kept in a file so that a
// killed run goes on where it was.

#ifndef FREEGS_SFM_STEP_RECORD_H_
#define FREEGS_SFM_STEP_RECORD_H_

#include <filesystem>
#include <set>
#include <string>

#include "core/status.h"

namespace freegs::sfm {

// steps.json in a work folder. A step is recorded after its files are complete;
// a step that is not recorded is done again. A file that cannot be understood
// counts as empty.
class StepRecord {
 public:
  explicit StepRecord(const std::filesystem::path& work_folder);

  bool Has(const std::string& step) const { return done_.contains(step); }
  const std::set<int>& portions() const { return portions_; }

  Status Add(const std::string& step);
  // A portion of the matching.
  Status AddPortion(int portion);

 private:
  Status Save() const;

  std::filesystem::path path_;
  std::set<std::string> done_;
  std::set<int> portions_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_STEP_RECORD_H_
