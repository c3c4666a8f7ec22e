// SPDX-License-Identifier: BSD-3-Clause
// Asks whether the poses of few photos depend on where the mapping began.
//
// Where photos overlap little, or a thing looks alike from two sides, it may be
// chance whether a photo gets its right place. The reprojection error does not
// tell, and neither does the number of points. But chance falls differently
// when the mapping begins with other photos, and right places do not change.

#ifndef FREEGS_SFM_MAPPING_CONFIRM_POSES_H_
#define FREEGS_SFM_MAPPING_CONFIRM_POSES_H_

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/mapping/attempt.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct ConfirmedPoses {
  // The models to be used instead of those given. Empty if these can stay as
  // they are.
  std::vector<Reconstruction> models;

  // Whether another model than the one given is the best of them.
  bool replaced = false;

  // Whether the best of them has a witness (see Consensus).
  bool witnessed = false;

  // Names of photos whose place is uncertain, ascending (see Consensus). They
  // are taken out of models[0] if enough others are left.
  std::vector<std::string> uncertain;

  // The further mappings, in order, each followed by the repairs of its models.
  std::vector<Attempt> attempts;
};

// More photos are not mapped again, because it takes too long.
inline constexpr size_t kMostPhotosToConfirm = 40;

// Maps the photos again, from the best pair after `skip` others; without `skip`
// COLMAP looks for a pair itself. The models, the best first, are as exact as
// those given. Returns nothing if there is no such pair.
using MapAgainFn = std::function<StatusOr<std::optional<AttemptResult>>(
    const std::string& name, std::optional<size_t> skip)>;

// Maps again until the best model has a witness (see Consensus), which usually
// takes one further mapping, and at most four times. Once a pair leads to no
// model, or there is none, COLMAP looks for one itself, and that is the last
// mapping. A model takes part if it has at least half as many photos as
// models[0], and is not one that is there already. `models` are the best first.
// With fewer than `enough` photos a model is of no use, so uncertain ones stay
// in it. Nothing is done without a model, and with more than
// kMostPhotosToConfirm photos in models[0]. Errors: those of map_again.
//
//   FREEGS_ASSIGN_OR_RETURN(ConfirmedPoses confirmed,
//                           ConfirmPoses(models, enough, map_again));
//   if (!confirmed.models.empty()) models = std::move(confirmed.models);
StatusOr<ConfirmedPoses> ConfirmPoses(const std::vector<Reconstruction>& models,
                                      size_t enough,
                                      const MapAgainFn& map_again);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_CONFIRM_POSES_H_
