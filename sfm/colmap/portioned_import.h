// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's matches_importer, run on fixed portions of the pairs of photos, one
// single-threaded program each: its random draws, and so the result, do not
// depend on how many run at once.

#ifndef FREEGS_SFM_COLMAP_PORTIONED_IMPORT_H_
#define FREEGS_SFM_COLMAP_PORTIONED_IMPORT_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/child_process.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {

using IdPair = std::pair<uint32_t, uint32_t>;

// The name of a photo in the copies that portions work on. (COLMAP's match
// lists are separated by spaces, which names of photos may have.)
std::string PlainPhotoName(uint32_t id);

struct PortionedImportOptions {
  // Receives what the portions make of their pairs.
  std::filesystem::path database;

  // What `prepare` makes of a copy of it, with plain names; portions work on
  // copies of that. Deleted in the end.
  std::function<Status(MatchDatabase&)> prepare;

  // matches_importer's match_type, "raw" or "pairs", and the text of such a
  // list for the pairs of a portion.
  std::string match_type;
  std::function<StatusOr<std::string>(const std::vector<IdPair>&)> list;

  // With "pairs": more matches are looked for along the epipolar lines of what
  // was verified (SiftMatching.guided_matching).
  bool guided = false;

  std::string step = "matching";  // What the user is told.
};

class PortionedImport {
 public:
  PortionedImport(const StepContext& context, PortionedImportOptions options);
  ~PortionedImport();
  PortionedImport(const PortionedImport&) = delete;
  PortionedImport& operator=(const PortionedImport&) = delete;

  // Imports the pairs, by ids of photos. Portions are numbered through all
  // calls; those in `done` are already in the database; on_done is told about
  // each more. kMissingDependency when this COLMAP lacks an option.
  Status Run(const std::vector<IdPair>& pairs,
             const std::set<int>& done,
             const std::function<Status(int portion)>& on_done);

 private:
  struct Portion {
    int number = 0;
    std::vector<IdPair> pairs;
  };
  Status MakeBase();
  StatusOr<ChildCommand> Start(const Portion& portion);
  Status Finish(const Portion& portion, const ChildResult& result);

  const StepContext& context_;
  const PortionedImportOptions options_;
  const std::filesystem::path base_path_;
  int num_portions_ = 0;  // Of the calls so far.
  double total_ = 0;      // Pairs.
  double imported_ = 0;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_PORTIONED_IMPORT_H_
