// SPDX-License-Identifier: BSD-3-Clause
// The truth's masks of a test view, and the instances that are judged by them.

#ifndef FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_
#define FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/function_ref.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// What a test view shows. Masks of different objects may overlap, therefore
// they lie in layers: object id per pixel, 0 for none, each object in one layer
// only.
using MaskLayers = std::vector<ImageU16>;

// The masks of `view` (one of truth.masks) as its camera sees them: of
// view.camera's size, without lens distortion, by nearest pixel. A file of a
// single object marks the pixels brighter than 128 (or, when none is brighter
// than 1, those that are not 0). kBadInput, naming the file, for images that
// cannot be read or are of another shape than the camera (by over 1 %), and for
// more than 256 masks.
StatusOr<MaskLayers> ReadTrueMasks(const GroundTruth& truth, const View& view);

// 255 where a layer has one of `objects`, else 0. All layers of the same size,
// at least one.
ImageU8 MaskOf(const MaskLayers& layers, const std::set<int>& objects);

// A test view with masks, and the instances that the scene shows there: label
// per pixel, negative for none, of the same size.
struct JudgedView {
  std::string name;
  MaskLayers truth;
  Image<int32_t> rendered;
};

// Calls `body` for each test view that has masks, in order, at a longest side
// of at most max_side pixels, and returns the first error. truth_views: the
// test views in the scene's world. instance_of_gaussian: one value per
// Gaussian, negative for none. kInterrupted when cancelled.
Status ForEachJudgedView(const WorkspaceScene& scene,
                         std::span<const int32_t> instance_of_gaussian,
                         const GroundTruth& truth,
                         const std::vector<View>& truth_views,
                         int max_side,
                         const CancellationToken& cancellation,
                         ThreadPool& pool,
                         FunctionRef<Status(const JudgedView&)> body);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_TRUE_MASKS_H_
