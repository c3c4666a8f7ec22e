// SPDX-License-Identifier: BSD-3-Clause
// What the rungs of the ladder do. Which is climbed when: see ladder.cc.

#ifndef FREEGS_SFM_MAPPING_LADDER_RUNGS_H_
#define FREEGS_SFM_MAPPING_LADDER_RUNGS_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

// Two models need so many photos in common to be merged.
inline constexpr size_t kSharedPhotos = 3;

// "more features" takes so many times sfm.max_features.
inline constexpr int kMoreFeatures = 2;

// What ways cost, as multiples of the plain way's features, matching, mapping.
inline constexpr double kMappingCost = 0.2;
inline constexpr double kMatchingCost = 0.7;
inline constexpr double kGuidedMatchingCost = 2 * kMatchingCost;
inline constexpr double kFeaturesCost = 0.1;
inline constexpr double kMoreFeaturesCost =
    kFeaturesCost * kMoreFeatures +
    kMatchingCost * kMoreFeatures * kMoreFeatures + 2 * kMappingCost;

// And images so large, in pixels, instead of `size`: half as large again, or
// more, up to twice, where that is still no more than 1600.
int LargerImageSize(int size);

// What a rung starts from.
struct RungInput {
  const StepContext& context;
  std::string name;
  const std::vector<Reconstruction>& models;  // The best first.
  const MatchedDatabase& database;            // What they were made from.
  std::filesystem::path folder;               // For the rung's own files.
};

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
