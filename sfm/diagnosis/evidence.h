// SPDX-License-Identifier: BSD-3-Clause
// What photos and their verified matches tell about a scene, whether or not a
// reconstruction came of it.

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
  bool readable = true;  // COLMAP could read it.
  int64_t num_features = 0;
  double sharpness = 0;      // As ingest measured it; 0 is unknown.
  double feature_scale = 0;  // Median, as a share of the longest side; or 0.
};

// Two photos with verified matches, by their places in SceneEvidence::photos.
struct PairEvidence {
  size_t first = 0;
  size_t second = 0;
  int64_t num_matches = 0;
  bool is_homography = false;
  std::optional<Eigen::Matrix3d> homography;  // Pixels of first to second.
};

struct SceneEvidence {
  std::vector<PhotoEvidence> photos;  // In the order of the input.
  std::vector<PairEvidence> pairs;
  size_t contradictions = 0;  // See view_graph.h.

  // Photos that a first model had, and that are not in the best one because
  // only what looks alike held them to it (separate_parts.h).
  std::vector<std::string> unplaced;
};

StatusOr<SceneEvidence> CollectEvidence(const std::vector<SfmPhoto>& photos,
                                        const MatchDatabase& database);

// Which photos belong together, as far as matches tell.
struct PhotoGroups {
  // For each photo the number of its group. Group 0 is the main one: that of
  // the best model if there is one, else the largest. The others follow by
  // size.
  std::vector<int> group;
  std::vector<std::vector<size_t>> members;  // Of each group, ascending.

  // For each photo, whether the best model has it.
  std::vector<bool> registered;
};

// Pairs with fewer verified matches do not join groups: two photos of
// different places get that far by chance.
inline constexpr int64_t kMinLink = 20;

// A group of so many photos is a part of its own and no stray photo.
inline constexpr size_t kMinGroup = 3;

// Photos are in one group when a chain of links, or a model of models (best
// first), joins them.
PhotoGroups GroupByMatches(const SceneEvidence& evidence,
                           const std::vector<Reconstruction>& models);

// How far pairs of photos are from having been taken by a camera that only
// turned.
struct TurningOnTheSpot {
  int64_t pairs = 0;            // Verified pairs.
  double homography_share = 0;  // Of them, those that a homography explains.

  // Of the homographies H, the median ratio of the largest to the smallest
  // singular value of inv(K) H K: 1 for a rotation. K has the focal length, out
  // of 0.5 to 1.6 times the longest side, for which this is least. 0 when there
  // are none. (With longer lenses a step along a wall looks like a turn.)
  double stretch = 0;

  // The camera only turned: nothing can be triangulated.
  bool certain() const {
    return pairs >= 3 && homography_share >= 0.85 && stretch > 0 &&
           stretch <= 1.08;
  }
};

TurningOnTheSpot MeasureTurning(const SceneEvidence& evidence);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_EVIDENCE_H_
