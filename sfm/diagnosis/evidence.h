// SPDX-License-Identifier: BSD-3-Clause
// Evidence for a diagnosis: what the photos and their verified matches tell
// about a scene, whether or not a model could be made from them.

#ifndef FREEGS_SFM_DIAGNOSIS_EVIDENCE_H_
#define FREEGS_SFM_DIAGNOSIS_EVIDENCE_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

struct PhotoEvidence {
  std::string name;
  int width = 0;  // Pixels.
  int height = 0;
  int64_t num_features = 0;
  double sharpness = 0;  // As ingest measured it; 0 if unknown.

  // Median size of its features, as a share of the photo's longest side; 0 if
  // unknown.
  double feature_scale = 0;
};

// Two photos with verified matches.
struct PairEvidence {
  size_t first = 0;   // Index into SceneEvidence::photos.
  size_t second = 0;  // Index into SceneEvidence::photos.
  int64_t num_matches = 0;

  // COLMAP found that a homography explains the matches as well as a general
  // motion does: the camera only turned, or what both photos show is a plane.
  bool is_homography = false;

  // Maps pixels of the first photo to pixels of the second. Only if
  // is_homography, and if it is known.
  std::optional<Eigen::Matrix3d> homography;
};

struct SceneEvidence {
  std::vector<PhotoEvidence> photos;  // In the order of the input.
  std::vector<PairEvidence> pairs;

  // Names of photos that were in a first model and are not in the final one,
  // because only look-alikes tied them to it (see separate_parts.h).
  std::vector<std::string> unplaced;

  // Names of photos whose place depends on which photos a mapping begins with
  // (see confirm_poses.h), whether or not the final model has them.
  std::vector<std::string> uncertain;
};

// Reads the evidence from a database. `unplaced` and `uncertain` stay empty.
// Errors: those of the database.
StatusOr<SceneEvidence> CollectEvidence(const std::vector<SfmPhoto>& photos,
                                        const MatchDatabase& database);

// The photos in groups, so that photos which show the same scene are in one.
struct PhotoGroups {
  // For each photo the number of its group. Group 0 is the main one: the group
  // of the best model, or without a model the largest. The others follow by
  // descending size.
  std::vector<int> group;

  // For each group its photos, as ascending indices.
  std::vector<std::vector<size_t>> members;

  // For each photo, whether it has a pose in the best model.
  std::vector<bool> registered;
};

// Fewer verified matches than these do not join two photos: photos of different
// places can have that many by chance.
inline constexpr int64_t kMinLink = 20;

// From this number of photos on a group counts as a part of its own; smaller
// groups are stray photos.
inline constexpr size_t kMinGroup = 3;

// Two photos are in one group if a chain of pairs with kMinLink matches or more
// connects them, or if one of the models has both. `models`: the best first.
PhotoGroups GroupByMatches(const SceneEvidence& evidence,
                           const std::vector<Reconstruction>& models);

// Tells whether the camera only turned on the spot. Then a homography H
// explains every pair, and with the calibration matrices K1 and K2 of the two
// photos inv(K2) H K1 is a rotation up to scale.
struct TurningOnTheSpot {
  int64_t pairs = 0;            // Number of pairs with verified matches.
  double homography_share = 0;  // Share of them that a homography explains.

  // The ratio of the largest to the smallest singular value of inv(K2) H K1,
  // median over the pairs: 1 for a rotation. The focal length is not known, so
  // 0.5 to 1.6 times the photo's longest side are tried, and the least median
  // counts. (Longer lenses are left out because through them a step along a
  // wall looks like a turn.) 0 if there is no homography.
  double stretch = 0;
  double focal = 0;  // The one that was best, as a share of the longest side.

  // True if the camera only turned, so that nothing can be triangulated.
  bool certain() const {
    return pairs >= 3 && homography_share >= 0.85 && stretch > 0 &&
           stretch <= 1.08;
  }
};

// Judges by all pairs of the evidence whether the camera only turned. If there
// are many, the stretch is that of about a thousand of them, evenly chosen.
TurningOnTheSpot MeasureTurning(const SceneEvidence& evidence);

// Compares the parallax in a model with the parallax in the homographies of its
// photos. When the camera moves sideways by 0.1 of the distance to the scene,
// the stretch of the homography (see above) grows by about 0.1, and the rays to
// a point that both photos see form an angle with a tangent of about 0.1.
// Returns the median, over the pairs with 10 such points or more, of
// (stretch - 1) / tangent of the median angle; 0 without such pairs.
//
// It was 0.49 or more in models of cameras that moved. It was 0.23 where the
// camera had turned on the spot, and a mapper had found a wrong lens with which
// it seems to walk around. `focal` is that of TurningOnTheSpot.
double ShownParallax(const SceneEvidence& evidence,
                     const Reconstruction& model,
                     double focal);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_EVIDENCE_H_
