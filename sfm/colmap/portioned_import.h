// SPDX-License-Identifier: BSD-3-Clause
// Runs COLMAP's matches_importer on fixed portions of the pairs of photos, each
// in a program with one thread. So its random draws, and with them the result,
// do not depend on how many programs run at the same time.

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

// The name that a photo has in the copies of the database that portions work
// on. It has no spaces, because COLMAP's match lists are separated by spaces.
std::string PlainPhotoName(uint32_t id);

struct PortionedImportOptions {
  // The database that receives the matches.
  std::filesystem::path database;

  // Makes the text of the match list (match_type "raw" of matches_importer) for
  // the pairs of a portion.
  std::function<StatusOr<std::string>(const std::vector<IdPair>&)> list;
};

// An import into one database:
//
//   PortionedImport import(context, std::move(options));
//   FREEGS_RETURN_IF_ERROR(import.Run(pairs, done, on_done));
class PortionedImport {
 public:
  PortionedImport(const StepContext& context, PortionedImportOptions options);
  ~PortionedImport();
  PortionedImport(const PortionedImport&) = delete;
  PortionedImport& operator=(const PortionedImport&) = delete;

  // Imports the matches of the pairs, which are ids of photos. Portions are
  // numbered from 0 on over all calls. Those in `done` are skipped, because the
  // database has them already; on_done is called with the number of each
  // further one. Returns kMissingDependency when this release of COLMAP lacks
  // an option.
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
  int num_portions_ = 0;  // In all calls so far.
  double total_ = 0;      // Pairs to import.
  double imported_ = 0;   // Pairs imported.
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_PORTIONED_IMPORT_H_
