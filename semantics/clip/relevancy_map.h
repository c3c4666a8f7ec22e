// SPDX-License-Identifier: BSD-3-Clause
// Where in an image a text is.

#ifndef FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_
#define FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_

#include <span>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/joint_bilateral_upsampling.h"

namespace freegs::semantics {

// The relevancy (see Relevancy) of every pixel of the guide, W x H x 1, by
// dense features, w x h x D, that are upsampled to it. `text` holds D numbers,
// `canonical` any multiple of D. Needs little memory beside the result,
// whatever the guide's size. kInvalidArgument as JointBilateralUpsample, and if
// the texts' sizes do not fit.
StatusOr<ImageF> RelevancyMap(const ImageF& features,
                              const ImageF& guide,
                              std::span<const float> text,
                              std::span<const float> canonical,
                              const JointBilateralOptions& options,
                              ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_RELEVANCY_MAP_H_
