// SPDX-License-Identifier: BSD-3-Clause
// Whether a model is one, or parts that were glued together by things that look
// alike. view_graph.h asks whether photos contradict their strongest matches;
// here all evidence between groups of photos is weighed. It is needed where the
// strongest matches are those that mislead.

#ifndef FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_
#define FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// What speaks for and against the places of two photos relative to each other.
struct PairSupport {
  uint32_t image_id1 = 0;  // Smaller than image_id2.
  uint32_t image_id2 = 0;
  // Matches that fit the cameras of the model, of a pair of which more than
  // half do; else 0: some fit wrong places, too.
  double supporting = 0;
  bool fits = false;  // More than half do.

  // Matches that do not, of a pair of which hardly any fits; and points that
  // both should show and do not (missing_correspondences.h), which count half.
  double against = 0;
};

// Verified matches fit when they lie within 4 pixels of the epipolar lines of
// the model's cameras and in front of both. Where a homography explains all
// matches of a pair they count a tenth: patterns on a plane repeat more often
// than shapes. When from 10 to 30 % of a pair's matches fit, those that do not
// count ever less: photos that show a pattern twice have matches of both kinds.
// model must pass CheckReconstruction.
StatusOr<std::vector<PairSupport>> MeasureSupport(
    const Reconstruction& model, const MatchDatabase& database);

struct ViewGroups {
  // Image ids; the largest group first, ascending within. One group when
  // nothing speaks against the model. Photos without evidence are in group 0.
  std::vector<std::vector<uint32_t>> groups;

  // Where the evidence is weakest, the share of it that supports the model:
  // 1 when nothing is against it. Models seen to be right had 0.49 or
  // more, glued ones 0.44 or less (docs/sfm.md).
  double score = 1;

  // Pairs across groups whose matches fit the model: what glued them.
  std::vector<std::pair<uint32_t, uint32_t>> suspects;

  bool consistent() const { return groups.size() <= 1; }
};

// Below this score a model is held to be glued.
inline constexpr double kMinSupport = 0.45;

// Joins, again and again, the two groups with the largest surplus of support,
// until no surplus is left (greedy additive edge contraction for correlation
// clustering: Keuper et al. 2015). Fewer than four photos are one group.
ViewGroups FindViewGroups(const Reconstruction& model,
                          const std::vector<PairSupport>& pairs);

// The model with these images only, and the points that two of them observe.
Reconstruction RestrictTo(const Reconstruction& model,
                          const std::vector<uint32_t>& image_ids);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_
