// SPDX-License-Identifier: BSD-3-Clause
// The single steps of structure from motion: features, matches, mapping. Used
// by structure_from_motion.cc, which knows their order and what is done.

#ifndef FREEGS_SFM_COLMAP_STEPS_H_
#define FREEGS_SFM_COLMAP_STEPS_H_

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap_program.h"
#include "sfm/structure_from_motion.h"

namespace freegs::sfm {

// What every step needs.
struct StepContext {
  const SfmInput& input;
  const SfmOptions& options;
  ColmapProgram& colmap;
  int num_threads = 1;

  std::filesystem::path LogFile(const std::string& command) const;
  void Report(const std::string& step,
              double done,
              double total,
              const std::string& detail) const;
};

// kUnusableResult with the last lines of output unless the program ended well.
Status CheckEnded(const StepContext& context,
                  const std::string& command,
                  const ChildResult& result);

// Makes a new database that knows the photos, in the order given, and their
// cameras, without features. Returns false, having done nothing, when this
// COLMAP cannot do that; ExtractFeatures then runs with one thread.
StatusOr<bool> RegisterPhotos(const StepContext& context,
                              const std::filesystem::path& database);

// Adds the features of all photos that have none yet.
Status ExtractFeatures(const StepContext& context,
                       const std::filesystem::path& database,
                       int num_threads);

// The size of images, in pixels, that is enough for options.max_features: from
// 800 to 1600, by the features that a few of the photos have at 800.
StatusOr<int> ChooseImageSize(const StepContext& context);

// The same for photos that have `found` features at 800.
int ImageSizeFor(int64_t found, int max_features);

// Matches the pairs that options.pairs choose into the database, in portions.
// `done` are the numbers of portions that earlier calls finished; on_done is
// told about each more.
StatusOr<MatchedPairs> MatchFeatures(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::set<int>& done,
    const std::function<Status(int portion)>& on_done);

// Runs the mapper into a new folder and reads the models it made (maybe none).
// relaxed: with thresholds for few or weakly connected photos.
StatusOr<std::vector<Reconstruction>> MapPhotos(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    bool relaxed);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_STEPS_H_
