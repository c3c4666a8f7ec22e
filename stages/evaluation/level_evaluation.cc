// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/level_evaluation.h"

#include <map>
#include <utility>
#include <vector>

#include "semantics/metrics/instance_metrics.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/scene_alignment.h"

namespace freegs::stages {
namespace {

// An object in a view: its pixels, and those that each region has in the view
// and shares with the object.
struct Sight {
  double truth = 0;
  std::vector<double> size;
  std::vector<double> shared;

  double Iou(size_t region) const {
    const double all = truth + size[region] - shared[region];
    return all > 0 ? shared[region] / all : 0;
  }
};

// The IoUs of the object in each view, with the region that fits it best in all
// of them together.
std::vector<double> BestIous(const std::vector<Sight>& sights) {
  Sight sum = sights[0];
  for (size_t v = 1; v < sights.size(); ++v) {
    sum.truth += sights[v].truth;
    for (size_t r = 0; r < sum.size.size(); ++r) {
      sum.size[r] += sights[v].size[r];
      sum.shared[r] += sights[v].shared[r];
    }
  }
  size_t best = 0;
  for (size_t r = 1; r < sum.size.size(); ++r) {
    if (sum.Iou(r) > sum.Iou(best)) best = r;
  }
  std::vector<double> ious;
  for (const Sight& sight : sights) ious.push_back(sight.Iou(best));
  return ious;
}

}  // namespace

StatusOr<std::optional<double>> MeasureBestLevels(
    const WorkspaceScene& scene,
    const semantics::Hierarchy& hierarchy,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  const semantics::RegionTree& tree = hierarchy.tree;
  std::map<int, std::vector<Sight>> sights;  // By object.
  const auto add_view = [&](const JudgedView& view) -> Status {
    for (const ImageU16& layer : view.truth) {
      FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceOverlap overlap,
                              semantics::CountOverlap(layer, view.rendered));
      std::vector<double> size(tree.num_leaves, 0.0);
      for (const auto& [part, pixels] : overlap.instance_pixels) {
        size[part] = static_cast<double>(pixels);
      }
      size = tree.Sums(size);
      for (const auto& [object, pixels] : overlap.truth_pixels) {
        if (pixels < kMinMaskPixels) continue;
        std::vector<double> shared(tree.num_leaves, 0.0);
        for (auto it = overlap.shared_pixels.lower_bound({object, 0});
             it != overlap.shared_pixels.end() && it->first.first == object;
             ++it) {
          shared[it->first.second] = static_cast<double>(it->second);
        }
        sights[object].push_back(
            {static_cast<double>(pixels), size, tree.Sums(shared)});
      }
    }
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(
      ForEachJudgedView(scene,
                        hierarchy.part_of_gaussian,
                        truth,
                        MapViews(truth.cameras.test, truth_from_scene),
                        kMaxMaskSide,
                        cancellation,
                        pool,
                        add_view));
  std::vector<double> ious;
  for (const auto& [object, of_object] : sights) {
    if (hierarchy.part_pixels.empty()) break;
    const std::vector<double> best = BestIous(of_object);
    ious.insert(ious.end(), best.begin(), best.end());
  }
  return MeanOrNothing(ious);
}

}  // namespace freegs::stages
