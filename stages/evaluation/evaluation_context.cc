// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/evaluation_context.h"

#include <vector>

#include "stages/scene/scene_alignment.h"

namespace freegs::stages {

Status EvaluationContext::ForEachView(
    std::span<const int32_t> labels,
    FunctionRef<Status(const JudgedView&)> body,
    int max_side) const {
  if (labels.size() != scene.model.size()) {
    return BadInputError("instances of " + std::to_string(labels.size()) +
                         " Gaussians for a scene of " +
                         std::to_string(scene.model.size()));
  }
  for (View& view : MapViews(truth.cameras.test, truth_from_scene)) {
    const auto masks = truth.masks.find(view.name);
    if (masks == truth.masks.end() || masks->second.empty()) continue;
    if (cancellation.cancelled()) {
      return InterruptedError("evaluation interrupted");
    }
    view.camera = view.camera.LimitedTo(max_side);
    JudgedView judged;
    judged.name = view.name;
    FREEGS_ASSIGN_OR_RETURN(judged.truth, ReadTrueMasks(truth, view, pool));
    judged.rendered = RenderLabels(scene, view, labels, pool);
    FREEGS_RETURN_IF_ERROR(body(judged));
  }
  return Status();
}

}  // namespace freegs::stages
