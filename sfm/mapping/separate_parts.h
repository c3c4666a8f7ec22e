// SPDX-License-Identifier: BSD-3-Clause
// What is done about models that consist of glued parts (see view_groups.h).

#ifndef FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_
#define FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

struct SeparatedParts {
  // As ViewGroups::score, and the number of groups, of the best model given.
  double score = 1;
  size_t groups = 1;

  // What replaces the models given, when that was glued: a model that is one,
  // or its parts, the largest first.
  std::vector<Reconstruction> models;
  MatchedDatabase database;  // What these were made from.

  // Whether the first of these holds together, by all matches of the database.
  bool one = false;

  // Photos of the model given whose places relative to the first of these are
  // unknown.
  std::vector<std::string> unplaced;

  std::vector<Attempt> attempts;
};

// Checks models[0] (the others are ignored, models may be empty). If it is
// glued, maps again without the pairs that glued it, and then with more
// features if sfm.max_retry_cost allows; when no way gives one consistent model
// of nearly all its photos, the one with the largest consistent part is taken
// apart.
StatusOr<SeparatedParts> SeparateParts(
    const StepContext& context,
    const MatchedDatabase& database,
    const std::vector<Reconstruction>& models,
    AttemptStore* store);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_
