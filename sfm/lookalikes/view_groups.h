// SPDX-License-Identifier: BSD-3-Clause
// Tells whether a model holds together, or consists of parts that were glued
// together by things that look alike: two equal chairs, or a table whose grain
// repeats after half a turn. Photos of such things match well and show
// different places. A mapper that trusts one such match puts photos where they
// never were, and its reprojection error stays low. So all evidence between
// groups of photos is weighed here.

#ifndef FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_
#define FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/lookalikes/pair_support.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct ViewGroups {
  // Image ids, ascending in each group; the largest group comes first. There is
  // a single group when the model holds together. Photos without any evidence
  // are in group 0.
  std::vector<std::vector<uint32_t>> groups;

  // The share of the evidence that supports the model, where this share is
  // least: 1 when nothing is against it. Of the models by which the limit was
  // chosen, right ones had 0.44 or more and glued ones 0.35 or less; others are
  // in docs/sfm.md.
  double score = 1;

  // Pairs of photos in different groups whose matches fit the model. They are
  // what glued the groups together.
  std::vector<std::pair<uint32_t, uint32_t>> suspects;

  bool consistent() const { return groups.size() <= 1; }
};

// A model with a score below this one counts as glued.
inline constexpr double kMinSupport = 0.4;

// Starts with each photo as a group of its own and keeps joining the two groups
// between which support exceeds what is against them by most, until no two are
// left where it does (greedy additive edge contraction for correlation
// clustering, Keuper et al. 2015). Fewer than four photos are always one group.
ViewGroups FindViewGroups(const Reconstruction& model,
                          const std::vector<PairSupport>& pairs);

// Opens the database, measures the support and finds the groups. Errors: those
// of the database.
//
//   const auto found = GroupViews(model, work_folder / "database.db");
//   if (!found.ok()) return found.status();
//   if (!found->consistent()) ...  // Only found->groups[0] can be trusted.
StatusOr<ViewGroups> GroupViews(const Reconstruction& model,
                                const std::filesystem::path& database);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_VIEW_GROUPS_H_
