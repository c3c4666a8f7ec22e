// SPDX-License-Identifier: BSD-3-Clause
// What the rungs of the ladder do. ladder.cc decides which of them is tried
// when.

#ifndef FREEGS_SFM_MAPPING_LADDER_RUNGS_H_
#define FREEGS_SFM_MAPPING_LADDER_RUNGS_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

// TakeMoreFeatures multiplies sfm.max_features by this.
inline constexpr int kMoreFeatures = 2;

// Estimated CPU times, as multiples of what the plain way takes in all for its
// features, matching and mapping. Times of matching grow with the square of the
// number of features.
inline constexpr double kMappingCost = 0.2;
inline constexpr double kMatchingCost = 0.7;
inline constexpr double kFeaturesCost = 0.1;
inline constexpr double kMoreFeaturesCost =
    kFeaturesCost * kMoreFeatures +
    kMatchingCost * kMoreFeatures * kMoreFeatures + 2 * kMappingCost;

// The longest side, in pixels, of the images that TakeMoreFeatures uses instead
// of `size`: twice as large but no more than 1600, or at least 1.5 times
// `size`.
int LargerImageSize(int size);

// What a rung starts from.
struct RungInput {
  const StepContext& context;
  std::string name;                           // Of the attempt, for the user.
  const std::vector<Reconstruction>& models;  // The best first; may be empty.
  const MatchedDatabase& database;            // The database they come from.
  std::filesystem::path folder;  // An empty folder for the rung's own files.
};

// All functions below return the errors of the COLMAP commands that they run.

// Maps the matches that are there with lower thresholds: weaker start pairs,
// fewer inliers.
StatusOr<AttemptResult> MapRelaxed(const RungInput& input);

// The others match anew, into a database of the rung, and map that.

// Matches all pairs of photos.
StatusOr<AttemptResult> MatchAllPairs(const RungInput& input);

// Takes kMoreFeatures times as many features, fainter ones too, from larger
// images, and matches them.
StatusOr<AttemptResult> TakeMoreFeatures(const RungInput& input);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_LADDER_RUNGS_H_
