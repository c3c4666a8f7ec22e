// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/consistency_evaluation.h"

#include <string>
#include <utility>
#include <vector>

#include "semantics/metrics/view_consistency.h"
#include "splat/render/renderer.h"
#include "stages/scene/view_selection.h"

namespace freegs::stages {
namespace {

// At most so many of the scene's photographs are compared.
constexpr int kNumViews = 16;

// Longest side in pixels of what is rendered.
constexpr int kMaxSide = 640;

std::vector<View> ChooseViews(const WorkspaceScene& scene) {
  std::vector<View> chosen = SpreadViews(PhotoViews(scene), kNumViews);
  for (View& view : chosen) view.camera = view.camera.LimitedTo(kMaxSide);
  return chosen;
}

semantics::LabelledView Label(const WorkspaceScene& scene,
                              std::span<const int32_t> instance_of_gaussian,
                              const View& view,
                              ThreadPool& pool) {
  semantics::LabelledView labelled;
  labelled.view = view;
  labelled.labels = RenderLabels(scene, view, instance_of_gaussian, pool);
  splat::RenderedView rendered = splat::RenderView(
      scene.model, view.camera, view.cam_from_world, scene.render, pool);
  // A pixel that is more than half transparent shows no surface.
  constexpr float kMaxTransmittance = 0.5f;
  for (size_t i = 0; i < rendered.depth.size(); ++i) {
    if (rendered.transmittance.data()[i] > kMaxTransmittance) {
      rendered.depth.data()[i] = 0;
    }
  }
  labelled.depth = std::move(rendered.depth);
  return labelled;
}

}  // namespace

StatusOr<std::optional<ViewConsistency>> MeasureViewConsistency(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  if (instance_of_gaussian.size() != scene.model.size()) {
    return BadInputError(
        "instances of " + std::to_string(instance_of_gaussian.size()) +
        " Gaussians for a scene of " + std::to_string(scene.model.size()));
  }
  const std::vector<View> views = ChooseViews(scene);
  std::vector<semantics::LabelledView> labelled;
  for (const View& view : views) {
    if (cancellation.cancelled()) {
      return InterruptedError("evaluation interrupted");
    }
    labelled.push_back(Label(scene, instance_of_gaussian, view, pool));
  }
  ViewConsistency consistency;
  std::map<int, std::pair<double, int>> sums;  // IoU and count by instance.
  for (const auto& [i, j] : semantics::NeighbouringViews(views)) {
    ++consistency.num_pairs;
    for (const auto& [from, to] : {std::pair(i, j), std::pair(j, i)}) {
      FREEGS_ASSIGN_OR_RETURN(
          const auto ious,
          semantics::CompareViews(labelled[from], labelled[to], {}));
      for (const auto& [instance, iou] : ious) {
        sums[instance].first += iou;
        ++sums[instance].second;
      }
    }
  }
  double sum = 0;
  int num_comparisons = 0;
  for (const auto& [instance, of_instance] : sums) {
    const auto& [ious, count] = of_instance;
    consistency.instances[instance] = ious / count;
    sum += ious;
    num_comparisons += count;
  }
  if (num_comparisons == 0) {
    return std::optional<ViewConsistency>();
  }
  consistency.mean = sum / num_comparisons;
  return std::optional(std::move(consistency));
}

}  // namespace freegs::stages
