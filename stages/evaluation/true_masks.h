// SPDX-License-Identifier: BSD-3-Clause
// Reads the truth's masks of test views and renders the instances that are
// compared with them.

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
StatusOr<MaskLayers> ReadTrueMasks(const GroundTruth& truth, const View& view);

// 255 where some layer has one of `objects`, else 0. There must be at least one
// layer, and all must be of the same size.
ImageU8 MaskOf(const MaskLayers& layers, const std::set<int>& objects);

// A test view that has masks, and what the scene shows there.
struct JudgedView {
  std::string name;
  MaskLayers truth;
  Image<int32_t> rendered;  // Label per pixel, negative for none; same size.
};

// Calls `body` for each of truth_views that has masks, in order, and returns
// the first error. truth_views are the truth's test views in the scene's world
// frame; they are rendered at a longest side of at most max_side pixels.
// `instance_of_gaussian` has one label per Gaussian of the scene, negative for
// none; kBadInput for another number. kInterrupted when cancelled.
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
