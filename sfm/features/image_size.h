// SPDX-License-Identifier: BSD-3-Clause
// How large the images must be that features are taken from.
//
// Only the largest max_features of the features found are kept. Where a large
// image has several times as many, the finest ones, which take most of the
// time, are found to be thrown away; a smaller image has the large ones too.

#ifndef FREEGS_SFM_FEATURES_IMAGE_SIZE_H_
#define FREEGS_SFM_FEATURES_IMAGE_SIZE_H_

#include <cstdint>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"

namespace freegs::sfm {

// Chooses the longest side, from 800 to 1600 pixels, of images that have
// options.max_features features. It finds the features of a few photos at 800
// pixels and concludes from their number.
StatusOr<int> ChooseImageSize(const StepContext& context);

// Does the same for photos that have `found` features at 800 pixels.
int ImageSizeFor(int64_t found, int max_features);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_FEATURES_IMAGE_SIZE_H_
