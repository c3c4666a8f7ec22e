// SPDX-License-Identifier: BSD-3-Clause
// Shows where in an image a text is.

#ifndef FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_
#define FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_

#include <span>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/joint_bilateral_upsampling.h"

namespace freegs::semantics {

// Returns the relevancy (see Relevancy()) of every pixel of the guide, W x H x
// 1. The dense features, w x h x D, are upsampled to the guide. `text` holds D
// numbers, `canonical` a multiple of D. Needs little memory beside the result,
// whatever the size of the guide. kInvalidArgument as JointBilateralUpsample,
// and for texts of the wrong size.
StatusOr<ImageF> RelevancyMap(const ImageF& features,
                              const ImageF& guide,
                              std::span<const float> text,
                              std::span<const float> canonical,
                              const JointBilateralOptions& options,
                              ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_
