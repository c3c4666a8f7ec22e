// SPDX-License-Identifier: BSD-3-Clause
// What all comparisons of a scene with a truth begin with, and the views in
// which they compare masks.

#ifndef FREEGS_STAGES_EVALUATION_EVALUATION_CONTEXT_H_
#define FREEGS_STAGES_EVALUATION_EVALUATION_CONTEXT_H_

#include <cstdint>
#include <span>
#include <string>

#include "core/cancellation.h"
#include "core/function_ref.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/rigid3d.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// An object with fewer pixels in a view is not judged in that view.
inline constexpr int kMinMaskPixels = 30;

// Longest side in pixels at which masks are compared. Larger masks are reduced
// to it.
inline constexpr int kMaxMaskSide = 1600;

// A test view that has masks, and what the scene shows there.
struct JudgedView {
  std::string name;
  MaskLayers truth;
  Image<int32_t> rendered;  // Label per pixel, negative for none; same size.
};

// A scene and the truth that it is compared with. What it refers to must
// outlive it.
struct EvaluationContext {
  const WorkspaceScene& scene;
  const GroundTruth& truth;
  Sim3d truth_from_scene;  // From the scene's frame to the truth's.
  const CancellationToken& cancellation;
  ThreadPool& pool;

  // Calls `body` for each of the truth's test views that has masks, in order,
  // and returns the first error. The views are rendered at a longest side of at
  // most max_side pixels. `labels` has one label per Gaussian of the scene,
  // negative for none; kBadInput for another number, and for masks that
  // ReadTrueMasks refuses. kInterrupted when cancelled.
  Status ForEachView(std::span<const int32_t> labels,
                     FunctionRef<Status(const JudgedView&)> body,
                     int max_side = kMaxMaskSide) const;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_EVALUATION_CONTEXT_H_
