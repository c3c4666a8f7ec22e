// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/consistency_evaluation.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "splat/render/renderer.h"

namespace freegs::stages {
namespace {

// At most `count` views of the scene, by name, spread evenly.
std::vector<View> ChooseViews(const WorkspaceScene& scene,
                              int count,
                              int max_side) {
  std::vector<View> all = scene.train;
  all.insert(all.end(), scene.holdout.begin(), scene.holdout.end());
  std::sort(all.begin(), all.end(), [](const View& a, const View& b) {
    return a.name < b.name;
  });
  const size_t wanted = std::min(all.size(), static_cast<size_t>(count));
  std::vector<View> chosen;
  for (size_t k = 0; k < wanted; ++k) {
    chosen.push_back(all[k * all.size() / wanted]);
    chosen.back().camera = chosen.back().camera.LimitedTo(max_side);
  }
  return chosen;
}

semantics::LabelledView Label(const WorkspaceScene& scene,
                              std::span<const int32_t> instance_of_gaussian,
                              const View& view,
                              ThreadPool& pool) {
  semantics::LabelledView labelled;
  labelled.view = view;
  labelled.labels = splat::RenderLabels(scene.model,
                                        view.camera,
                                        view.cam_from_world,
                                        scene.render,
                                        pool,
                                        instance_of_gaussian);
  splat::RenderedView rendered = splat::RenderView(
      scene.model, view.camera, view.cam_from_world, scene.render, pool);
  // What is more than half transparent is no surface.
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

Status ConsistencyOptions::Check() const {
  if (num_views < 2)
    return InvalidArgumentError("num_views must be at least 2");
  if (max_side < 1) return InvalidArgumentError("max_side must be at least 1");
  return compare.Check();
}

StatusOr<std::optional<ViewConsistency>> MeasureViewConsistency(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const ConsistencyOptions& options,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (instance_of_gaussian.size() != scene.model.size()) {
    return BadInputError(
        "instances of " + std::to_string(instance_of_gaussian.size()) +
        " Gaussians for a scene of " + std::to_string(scene.model.size()));
  }
  const std::vector<View> views =
      ChooseViews(scene, options.num_views, options.max_side);
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
          semantics::CompareViews(
              labelled[from], labelled[to], options.compare));
      for (const auto& [instance, iou] : ious) {
        sums[instance].first += iou;
        ++sums[instance].second;
      }
    }
  }
  double sum = 0;
  for (const auto& [instance, of_instance] : sums) {
    const auto& [ious, count] = of_instance;
    consistency.instances[instance] = ious / count;
    sum += ious;
    consistency.num_comparisons += count;
  }
  if (consistency.num_comparisons == 0) {
    return std::optional<ViewConsistency>();
  }
  consistency.mean = sum / consistency.num_comparisons;
  return std::optional(std::move(consistency));
}

}  // namespace freegs::stages
