// SPDX-License-Identifier: BSD-3-Clause
// Maps a part of many photos, the skeleton, and registers the others to it.
//
// A mapper adjusts its model again and again while the model grows, so its time
// grows faster than the number of photos. But where photos overlap much, a part
// of them tells as much about the scene. The other photos are then placed one
// by one, by the points that the skeleton has, and all are adjusted once at the
// end (Snavely et al., "Skeletal graphs for efficient structure from motion",
// 2008, choose the part in another way).

#ifndef FREEGS_SFM_MAPPING_SKELETON_H_
#define FREEGS_SFM_MAPPING_SKELETON_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// How many partners each photo has in the skeleton, whether it belongs to the
// skeleton or not. A photo with fewer partners has all of them there.
inline constexpr int kSkeletonPartners = 6;

// Two photos are partners if they have 50 verified matches or more, and one of
// them is among the 20 with which the other has most. Chooses photos, the one
// first that most others still need, until each photo has its partners among
// them (the greedy way to a small dominating set). Returns their ids,
// ascending. Photos without partners are not among them.
std::vector<uint32_t> ChooseSkeleton(
    std::span<const MatchDatabase::VerifiedPair> pairs);

// Maps a skeleton of the photos as MapFromBestPair does, registers the other
// photos, triangulates all points anew, and lets the mapper go on with photos
// that are still without a pose. Returns one model. The poses of the other
// photos are not adjusted yet, which is left to the choice of cameras. Returns
// nothing if the skeleton has more than half of the photos.
//
//   FREEGS_ASSIGN_OR_RETURN(std::vector<Reconstruction> models,
//                           MapFromSkeleton(context, database, folder));
//   if (models.empty()) ...  // The plain way.
//
// `folder` is made anew for COLMAP's output and deleted at the end. Errors:
// those of MapPhotos and of the database, and kUnusableResult if less than nine
// tenths of the skeleton get a pose.
StatusOr<std::vector<Reconstruction>> MapFromSkeleton(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_SKELETON_H_
