// SPDX-License-Identifier: BSD-3-Clause
// Features at the lower edge of a photo, whose descriptors COLMAP leaves unset.
//
// VLFeat, which takes COLMAP's features on a CPU, computes no descriptor for a
// feature whose centre falls into the last row of the image of its octave, and
// COLMAP does not ask. So the database holds what was in memory there, which
// differs from run to run. One feature in some thousands is such a one.
// Source: vl_sift_calc_keypoint_descriptor in VLFeat 0.9.20 (vl/sift.c).

#ifndef FREEGS_SFM_MATCHING_EDGE_FEATURES_H_
#define FREEGS_SFM_MATCHING_EDGE_FEATURES_H_

#include <vector>

#include "sfm/matching/descriptor_matching.h"

namespace freegs::sfm {

// Where a feature lies in its photo, and its size, in pixels. The top-left
// pixel's centre is (0.5, 0.5).
struct FeaturePlace {
  float x = 0;
  float y = 0;
  float scale = 0;
};

// Whether the feature's descriptor may be unset, in an image of this height.
// Both are in pixels of the image that features were taken from.
bool IsInLastRow(double y, double scale, int height);

// Sets descriptors that may be unset to zero, which matches nothing. The
// features are in pixels of the photo; they were taken from an image whose
// longest side is at most `max_image_size` pixels. Does nothing when there are
// not as many features as descriptors.
void ClearUnsetDescriptors(const std::vector<FeaturePlace>& features,
                           int photo_width,
                           int photo_height,
                           int max_image_size,
                           SiftDescriptors* descriptors);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_EDGE_FEATURES_H_
