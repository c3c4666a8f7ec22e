// SPDX-License-Identifier: BSD-3-Clause
// One way that was tried to get a model, and what came of it.

#ifndef FREEGS_SFM_MAPPING_ATTEMPT_H_
#define FREEGS_SFM_MAPPING_ATTEMPT_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/mapping/step_record.h"
#include "sfm/matching/pair_selection.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// For health.json.
struct Attempt {
  std::string name;  // "mapping", "lower thresholds" ...
  std::string why;   // What had been seen that made it worth trying.

  // About the best model there is after it, of those it made.
  int registered = 0;
  int models = 0;  // How many it made.
  size_t points = 0;
  double mean_error_px = 0;

  bool kept = false;    // Its models replaced the ones before.
  std::string problem;  // Why it ended without models, or was not begun.
};

// An attempt that made the models, the best first, with their measures.
Attempt DescribeAttempt(const std::string& name,
                        const std::string& why,
                        const std::vector<Reconstruction>& models);

// A database of matches, and how it was filled.
struct MatchedDatabase {
  std::filesystem::path path;
  MatchedPairs pairs;
  int image_size = 0;  // max_image_size, or what was chosen.
};

// What an attempt made.
struct AttemptResult {
  std::vector<Reconstruction> models;  // Best first; may be empty.

  // The database that the models were made from, when it is another one than
  // before: it lies in the attempt's folder.
  bool has_database = false;

  // With a database: the pairs of photos that were matched for it, and the size
  // of the images that features were taken from, if it was another one; else 0.
  MatchedPairs pairs;
  int image_size = 0;

  std::map<std::string, int64_t> counts;  // Whatever else is to be kept.

  std::string problem;  // Why there is nothing (see AttemptStore::Try).
};

// Where an attempt's own database is in its folder, if it has one.
inline std::filesystem::path AttemptDatabase(
    const std::filesystem::path& folder) {
  return folder / "database.db";
}

// Runs attempts once: their results are kept in a folder each, until Remove().
class AttemptStore {
 public:
  AttemptStore(const std::filesystem::path& work_folder, StepRecord* record)
      : folder_(work_folder / "attempts"), record_(record) {}

  std::filesystem::path Folder(const std::string& name) const;

  // The result of the attempt as it was recorded, or else of `run`, which may
  // write into the attempt's new, empty folder. Errors of run are returned, and
  // not recorded.
  StatusOr<AttemptResult> Run(
      const std::string& name,
      const std::function<StatusOr<AttemptResult>()>& run);

  // As Run; but errors other than kInterrupted and kInternal make a result
  // without models that has the message, and which is not recorded either.
  StatusOr<AttemptResult> Try(
      const std::string& name,
      const std::function<StatusOr<AttemptResult>()>& run);

  // What the models of the attempt were made from: its own database, if it has
  // one, or else `before`.
  MatchedDatabase DatabaseOf(const std::string& name,
                             const AttemptResult& result,
                             const MatchedDatabase& before) const;

  // Deletes the database, and its list of pairs, of an attempt that was not
  // kept.
  void RemoveDatabaseOf(const std::string& name) const;

  // Deletes all that is kept in a work folder.
  static void Remove(const std::filesystem::path& work_folder);

 private:
  StatusOr<AttemptResult> Read(const std::string& name) const;
  Status Write(const std::string& name, const AttemptResult& result);

  std::filesystem::path folder_;
  StepRecord* record_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_ATTEMPT_H_
