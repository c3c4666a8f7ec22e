// SPDX-License-Identifier: BSD-3-Clause
// Points for cameras whose poses are known, from the photos.

#ifndef FREEGS_SFM_MAPPING_KNOWN_POSES_H_
#define FREEGS_SFM_MAPPING_KNOWN_POSES_H_

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/diagnosis/finding.h"
#include "sfm/matching/pair_selection.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct TriangulatedScene {
  // The given cameras and poses, with the features of the photos and with
  // coloured points.
  Reconstruction model;

  // The share of the verified matches between photos that became one point.
  // Nothing if there are no matches, which tell nothing about the poses.
  std::optional<double> fitting_share;

  // Empty, or that the poses, or those of some photos, do not fit the photos.
  std::vector<Finding> findings;

  MatchedPairs pairs;  // The pairs of photos that were compared.
  int image_size = 0;  // Longest side, in pixels, that features are taken from.
  int max_features = 0;  // The most that were kept of a photo.
  std::string colmap_version;
  std::vector<std::string> warnings;
};

// The verified matches of two photos, and how many of them became one point.
struct PairFit {
  uint32_t id1 = 0;
  uint32_t id2 = 0;
  int64_t matched = 0;
  int64_t fitting = 0;
};

// The photos whose poses seem to be wrong while those of most others are right,
// each with the share of its matches that fits: those with at least 30 matches
// of which less than a quarter fit, also when matches with each other do not
// count.
std::map<uint32_t, double> PhotosThatDoNotFit(std::span<const PairFit> pairs);

// Takes features from the photos, matches them, and triangulates the matches
// from the given poses, with the given cameras whatever the options say. The
// images of `poses` are photos of `input`, by name;
// other photos are left out. Its ids may change. There may be few points, or
// none. The poses do not fit the photos (another scene, other axes, another
// lens) if less than half of the matches fit them: it was 0.72 or more with
// right ones and with those that are 2 pixels off, and 0.09 at 10 pixels.
//
//   FREEGS_ASSIGN_OR_RETURN(const TriangulatedScene scene,
//                           TriangulateScene(input, SfmOptions(), poses));
//   TidyWorkFolder(input.work_folder);
//
// Errors: those of RunStructureFromMotion. The same input gives the same
// points, byte for byte, whatever the number of threads.
StatusOr<TriangulatedScene> TriangulateScene(const SfmInput& input,
                                             const SfmOptions& options,
                                             const Reconstruction& poses);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_KNOWN_POSES_H_
