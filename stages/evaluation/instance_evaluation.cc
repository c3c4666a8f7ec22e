// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/instance_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "semantics/metrics/box_iou.h"
#include "semantics/metrics/instance_metrics.h"
#include "stages/evaluation/evaluation.h"

namespace freegs::stages {
namespace {

// What is gathered about one object of the truth, view by view.
struct ObjectTally {
  std::vector<double> instance_ious;
  std::vector<double> click_ious;
};

// What is gathered over the views.
struct Tally {
  std::map<int, ObjectTally> objects;
  semantics::InstanceOverlap overlap;
  bool any_view = false;
};

Status AddView(const JudgedView& view,
               bool complete,
               Tally* tally,
               InstanceQuality* quality) {
  semantics::InstanceOverlap overlap;
  for (const ImageU16& layer : view.truth) {
    StatusOr<semantics::InstanceOverlap> of_layer =
        semantics::CountOverlap(layer, view.rendered);
    if (!of_layer.ok()) return of_layer.status().Annotated(view.name);
    for (const auto& [object, pixels] : of_layer->truth_pixels) {
      if (pixels < kMinMaskPixels) continue;
      ObjectTally& of_object = tally->objects[object];
      const auto best = semantics::BestMatch(*of_layer, object);
      of_object.instance_ious.push_back(best ? best->iou : 0);
      const auto click = semantics::ClickPoint(layer, object);
      const int clicked = view.rendered(click->x(), click->y());
      of_object.click_ious.push_back(
          clicked < 0 ? 0 : of_layer->Iou(object, clicked));
    }
    // Every layer counts the pixels of all instances; they must enter the sum
    // only once.
    if (&layer != &view.truth.front()) of_layer->instance_pixels.clear();
    overlap.Add(*of_layer);
  }
  if (complete) {
    quality->panoptic.emplace_back(
        view.name, semantics::MatchSegments(overlap, kMinMaskPixels));
    quality->panoptic_sum.Add(quality->panoptic.back().second);
  }
  tally->overlap.Add(overlap);
  tally->any_view = true;
  return Status();
}

// The instance whose box has the highest IoU; -1 when no box overlaps.
int BestBox(const semantics::AxisAlignedBox& box,
            const std::vector<semantics::Instance>& instances) {
  int best = -1;
  double best_iou = 0;
  for (size_t k = 0; k < instances.size(); ++k) {
    if (instances[k].num_gaussians == 0) continue;
    const double iou = semantics::BoxIou(box, instances[k].aabb);
    if (iou > best_iou) {
      best = static_cast<int>(k);
      best_iou = iou;
    }
  }
  return best;
}

// Finds the instance of each true object and compares their boxes.
void FillObjects(const std::vector<TrueObject>& objects,
                 const Tally& tally,
                 const std::vector<semantics::Instance>& instances,
                 std::map<int, ObjectResult>* results,
                 InstanceQuality* quality) {
  for (const auto& [object, of_object] : tally.objects) (*results)[object];
  for (const TrueObject& object : objects) {
    (*results)[object.id].label = object.label;
  }
  for (auto& [id, result] : *results) {
    result.id = id;
    const auto match = semantics::BestMatch(tally.overlap, id);
    if (match) result.instance = match->instance;
  }
  std::vector<double> ious;
  for (const TrueObject& object : objects) {
    if (!object.aabb) continue;
    ObjectResult& result = (*results)[object.id];
    // No view shows which instance it is.
    if (!tally.overlap.truth_pixels.contains(object.id)) {
      result.instance = BestBox(*object.aabb, instances);
    }
    result.box_iou = 0;
    if (result.instance >= 0) {
      result.box = instances[static_cast<size_t>(result.instance)].aabb;
      result.box_iou = semantics::BoxIou(*object.aabb, *result.box);
    }
    ious.push_back(*result.box_iou);
  }
  quality->boxes = SummariseBoxes(ious);
}

void FillMasks(const Tally& tally,
               std::map<int, ObjectResult>* results,
               InstanceQuality* quality) {
  std::vector<double> instance_ious;
  std::vector<double> click_ious;
  for (const auto& [object, of_object] : tally.objects) {
    ObjectResult& result = (*results)[object];
    result.num_views = static_cast<int>(of_object.instance_ious.size());
    result.instance_iou = MeanOrNothing(of_object.instance_ious);
    result.click_iou = MeanOrNothing(of_object.click_ious);
    instance_ious.insert(instance_ious.end(),
                         of_object.instance_ious.begin(),
                         of_object.instance_ious.end());
    click_ious.insert(click_ious.end(),
                      of_object.click_ious.begin(),
                      of_object.click_ious.end());
  }
  quality->instance_miou = MeanOrNothing(instance_ious);
  quality->click_miou = MeanOrNothing(click_ious);
}

}  // namespace

std::optional<double> MeanOrNothing(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::optional<BoxQuality> SummariseBoxes(const std::vector<double>& ious) {
  if (ious.empty()) return std::nullopt;
  const auto recall = [&ious](double threshold) {
    const auto found = std::count_if(
        ious.begin(), ious.end(), [&](double v) { return v >= threshold; });
    return static_cast<double>(found) / static_cast<double>(ious.size());
  };
  return BoxQuality{*MeanOrNothing(ious), recall(0.25), recall(0.5)};
}

std::vector<semantics::Instance> InstancesInTruth(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian) {
  const splat::GaussianModel& model = context.scene.model;
  const Sim3d& truth_from_scene = context.truth_from_scene;
  // The positions become float32, which is too coarse for a truth in the
  // coordinates of a map, so they count from the origin of the scene.
  const Eigen::Vector3d& origin = truth_from_scene.translation;
  Sim3d turned = truth_from_scene;
  turned.translation.setZero();
  // Boxes do not depend on colours, so these are left out.
  splat::GaussianModel moved;
  moved.Resize(model.size());
  moved.opacity_logits = model.opacity_logits;
  const auto log_scale = static_cast<float>(std::log(truth_from_scene.scale));
  int num_labels = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    const Eigen::Vector3d mean =
        turned * Eigen::Vector3d(model.means[3 * i],
                                 model.means[3 * i + 1],
                                 model.means[3 * i + 2]);
    for (int k = 0; k < 3; ++k) {
      moved.means[3 * i + k] = static_cast<float>(mean[k]);
      moved.log_scales[3 * i + k] = model.log_scales[3 * i + k] + log_scale;
    }
    const Eigen::Quaterniond rotation =
        truth_from_scene.rotation *
        Eigen::Quaterniond(model.rotations[4 * i],
                           model.rotations[4 * i + 1],
                           model.rotations[4 * i + 2],
                           model.rotations[4 * i + 3]);
    moved.rotations[4 * i] = static_cast<float>(rotation.w());
    moved.rotations[4 * i + 1] = static_cast<float>(rotation.x());
    moved.rotations[4 * i + 2] = static_cast<float>(rotation.y());
    moved.rotations[4 * i + 3] = static_cast<float>(rotation.z());
    num_labels = std::max(num_labels, instance_of_gaussian[i] + 1);
  }
  std::vector<semantics::Instance> instances =
      semantics::BuildInstances(moved,
                                instance_of_gaussian,
                                num_labels,
                                /*scores=*/{},
                                /*background=*/{},
                                /*vertical=*/std::nullopt,
                                semantics::InstanceBoxOptions(),
                                context.pool);
  for (semantics::Instance& instance : instances) {
    instance.centre += origin;
    instance.aabb.min += origin;
    instance.aabb.max += origin;
    instance.obb.centre += origin;
  }
  return instances;
}

StatusOr<std::optional<InstanceQuality>> MeasureInstanceQuality(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian) {
  const GroundTruth& truth = context.truth;
  InstanceQuality quality;
  Tally tally;
  FREEGS_RETURN_IF_ERROR(
      context.ForEachView(instance_of_gaussian, [&](const JudgedView& view) {
        return AddView(view, truth.complete, &tally, &quality);
      }));
  const bool any_box = std::any_of(
      truth.objects.begin(), truth.objects.end(), [](const TrueObject& object) {
        return object.aabb.has_value();
      });
  if (!tally.any_view && !any_box) return std::optional<InstanceQuality>();

  std::map<int, ObjectResult> results;
  FillMasks(tally, &results, &quality);
  if (tally.any_view) {
    quality.balance = semantics::MeasureSegmentationBalance(tally.overlap);
  }
  FillObjects(truth.objects,
              tally,
              InstancesInTruth(context, instance_of_gaussian),
              &results,
              &quality);
  for (auto& [id, result] : results) {
    quality.objects.push_back(std::move(result));
  }
  return std::optional(std::move(quality));
}

}  // namespace freegs::stages
