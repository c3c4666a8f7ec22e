// SPDX-License-Identifier: BSD-3-Clause
// What speaks for and against the poses that a model gives two photos: matches
// that fit them, matches that do not, and matches that are missing.

#ifndef FREEGS_SFM_LOOKALIKES_PAIR_SUPPORT_H_
#define FREEGS_SFM_LOOKALIKES_PAIR_SUPPORT_H_

#include <cstdint>
#include <vector>

#include "core/status.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The evidence for and against the relative pose of two photos in a model, in
// (weighted) numbers of matches.
struct PairSupport {
  uint32_t image_id1 = 0;  // Smaller than image_id2.
  uint32_t image_id2 = 0;

  // Number of fitting matches if `fits`. Otherwise 0, because some matches fit
  // by chance even where the poses are wrong.
  double supporting = 0;

  // True if more than half of the verified matches fit the poses.
  bool fits = false;

  // Number of matches that do not fit, counted only where hardly any match
  // fits (see MeasureSupport); and half the number of missing points (see
  // missing_correspondences.h).
  double against = 0;
};

// Measures the evidence for all pairs of photos of the model. A verified match
// fits when its Sampson error is below 4 pixels with the model's cameras, and
// the point lies in front of both. That is up to 5.7 pixels from both epipolar
// lines where the error is the same in both photos.
//
// Patterns on a plane repeat more often than shapes do. So the matches of a
// pair count less, down to a fifth, the more of them one homography explains
// (from 60 to 80 %). Matches that do not fit count in full if at most 10 % of
// the pair's matches fit, less and less up to 30 %, and not at all beyond:
// photos that show a pattern twice have matches of both kinds.
//
// The model must pass CheckReconstruction. Errors: those of the database.
StatusOr<std::vector<PairSupport>> MeasureSupport(
    const Reconstruction& model, const MatchDatabase& database);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_PAIR_SUPPORT_H_
