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

// Two models need at least this many photos in common to be merged.
inline constexpr size_t kSharedPhotos = 3;

// TakeMoreFeatures multiplies sfm.max_features by this.
inline constexpr int kMoreFeatures = 2;

// Estimated CPU times, as multiples of what the plain way takes in all for its
// features, matching and mapping. Times of matching grow with the square of the
// number of features.
inline constexpr double kMappingCost = 0.2;
inline constexpr double kMatchingCost = 0.7;
inline constexpr double kGuidedMatchingCost = 2 * kMatchingCost;
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

// Mapping the same matches: with lower thresholds; with other random draws;
// with a mapper of another kind (COLMAP 4's global one, else the hierarchical).
StatusOr<AttemptResult> MapRelaxed(const RungInput& input);
StatusOr<AttemptResult> MapWithOtherSeed(const RungInput& input);
StatusOr<AttemptResult> MapOtherwise(const RungInput& input);

// Merges the models that share photos into the best one.
StatusOr<AttemptResult> MergeAll(const RungInput& input);

// Adds photos to the best model with low thresholds; COLMAP 4 also places them
// by other photos alone, without points (its structure-less registration).
StatusOr<AttemptResult> AddPhotos(const RungInput& input);

// Other matches, into the database of the rung: more of them for photos that
// the best model lacks and that match others, along the epipolar lines of what
// is known to match; of all pairs; of descriptors that are less alike; of more,
// and fainter, features in larger images.
StatusOr<AttemptResult> MatchMoreGuided(const RungInput& input);
StatusOr<AttemptResult> MatchAllPairs(const RungInput& input);
StatusOr<AttemptResult> MatchLoosely(const RungInput& input);
StatusOr<AttemptResult> TakeMoreFeatures(const RungInput& input);

// How many photos two models share.
size_t NumShared(const Reconstruction& a, const Reconstruction& b);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_LADDER_RUNGS_H_
