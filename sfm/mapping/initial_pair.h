// SPDX-License-Identifier: BSD-3-Clause
// Chooses the two photos with which a mapper begins, and begins there.
//
// A model grows from the points that two photos see. They are good if many
// matches of the two tell how far away things are. Two photos of one plane, or
// of a camera that only turned, have thousands of matches that do not.
//
// COLMAP goes through the photos, those with most matches first, and takes the
// first pair whose rays meet at 16 degrees or more. If there is none it lowers
// its limits, and goes through all pairs again: half of the mapper's time where
// the camera moved little. Here all pairs are compared.

#ifndef FREEGS_SFM_MAPPING_INITIAL_PAIR_H_
#define FREEGS_SFM_MAPPING_INITIAL_PAIR_H_

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

// The motion between two photos, and what it does to the rays of their matches.
struct PairMotion {
  int64_t in_front = 0;  // Matches whose rays meet in front of both cameras.
  double angle_deg = 0;  // Median angle between those rays.
  double forward = 0;    // How much of the way lies along the view: 0 to 1.
};

// Takes an essential matrix E apart, with ray2^T E ray1 = 0 for all matches,
// and takes the one of the four motions that puts most of them in front of both
// cameras (Hartley and Zisserman, Multiple View Geometry, 9.6.2). Column i of
// rays1 and of rays2 is the point (x, y, 1) of a camera frame that match i
// sees.
PairMotion MeasureMotion(const Eigen::Matrix3d& essential,
                         const Eigen::Matrix3Xd& rays1,
                         const Eigen::Matrix3Xd& rays2);

// Returns the pair of photos with the largest product of
//   - the matches that lie in front of both cameras,
//   - the angle between their rays, of which 16 degrees are enough, and
//   - the share of matches that no homography explains.
// Only matches between the given photos count, and both photos are in the
// largest group of these that matches connect. Neither is one of `in_vain`,
// which are pairs that led to nothing. Returns nothing if no pair has
// 30 such matches, an angle of 1.5 degrees, and a way that is not straight
// ahead. A focal length that is not known counts as 1.2 times the photo's
// longer side. Errors: those of the database.
StatusOr<std::optional<InitialPair>> ChooseInitialPair(
    const std::vector<SfmPhoto>& photos,
    std::span<const InitialPair> in_vain,
    const MatchDatabase& database);

// The best pair of a database, the best one of the other photos, and so on:
// `count` pairs, or fewer if there are no more.
StatusOr<std::vector<InitialPair>> BestPairs(
    const std::vector<SfmPhoto>& photos,
    size_t count,
    const std::filesystem::path& database);

// Maps the database from the last of `pairs`, which are the first ones of
// BestPairs, and again from the best pair of the photos that are left, as long
// as these are 10 or more. The other pairs of `pairs` are passed over. Models
// are kept if they have 10 of the photos, or half of few, and are not part of
// the largest one. When three pairs led to smaller ones, no further is tried.
// Returns the models, the largest first; there may be none, as without `pairs`.
// `folder` is made anew for COLMAP's output and deleted at the end. `options`
// may have all but a pair and a model to start from. Errors: those of MapPhotos
// and of the database.
StatusOr<std::vector<Reconstruction>> MapFromLastPair(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    std::vector<InitialPair> pairs,
    const MapperOptions& options = {});

// Maps the database like MapFromLastPair, but from the best pair of BestPairs.
// If there is no model then, COLMAP looks for pairs itself.
//
//   FREEGS_ASSIGN_OR_RETURN(const std::vector<Reconstruction> models,
//                           MapFromBestPair(context, database, folder));
StatusOr<std::vector<Reconstruction>> MapFromBestPair(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const MapperOptions& options = {});

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_INITIAL_PAIR_H_
