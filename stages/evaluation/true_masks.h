// SPDX-License-Identifier: BSD-3-Clause
// Reads the truth's masks of test views.

#ifndef FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_
#define FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_

#include <set>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// The true objects in a test view: images of object ids, 0 for none. Masks of
// different objects may overlap, so there can be several layers; each object
// lies in one layer only.
using MaskLayers = std::vector<ImageU16>;

// Reads the masks of `view`, which is one of truth.masks, as its camera sees
// them: of view.camera's size, without lens distortion, by nearest pixel. A
// file of a single object marks the pixels brighter than 128; if no pixel is
// brighter than 1 it marks those that are not 0. kBadInput, naming the file,
// for images that cannot be read or whose aspect differs from the camera's by
// more than 1 %, and for more than 256 masks.
StatusOr<MaskLayers> ReadTrueMasks(const GroundTruth& truth,
                                   const View& view,
                                   ThreadPool& pool);

// 255 where some layer has one of `objects`, else 0. There must be at least one
// layer, and all must be of the same size.
ImageU8 MaskOf(const MaskLayers& layers, const std::set<int>& objects);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_
