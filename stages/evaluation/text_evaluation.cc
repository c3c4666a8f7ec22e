// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/text_evaluation.h"

#include <algorithm>
#include <utility>

#include "semantics/metrics/boundary_iou.h"
#include "semantics/metrics/box_iou.h"
#include "semantics/metrics/instance_metrics.h"
#include "stages/evaluation/evaluation.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

// One label, its objects, and what is gathered about it view by view.
struct LabelTally {
  std::set<int> objects;
  std::vector<semantics::AxisAlignedBox> boxes;
  TextAnswer answer;
  std::vector<double> ious;
  std::vector<double> boundary_ious;
};

using LabelTallies = std::map<std::string, LabelTally>;

LabelTallies Prepare(const std::vector<TrueObject>& objects,
                     const std::map<std::string, TextAnswer>& answers) {
  LabelTallies tallies;
  for (const TrueObject& object : objects) {
    if (object.label.empty()) continue;
    LabelTally& tally = tallies[object.label];
    tally.objects.insert(object.id);
    if (object.aabb) tally.boxes.push_back(*object.aabb);
    const auto answer = answers.find(object.label);
    if (answer != answers.end()) tally.answer = answer->second;
  }
  return tallies;
}

Status AddView(const JudgedView& view, LabelTally* tally) {
  const ImageU8 truth = MaskOf(view.truth, tally->objects);
  const auto pixels =
      std::count(truth.data(), truth.data() + truth.size(), uint8_t{255});
  if (pixels < kMinMaskPixels) return Status();
  // Without an answer the mask is empty. InstanceMask(-1) would mark the pixels
  // that belong to no instance.
  const ImageU8 found =
      tally->answer.instance < 0
          ? ImageU8(truth.width(), truth.height(), 1)
          : InstanceMask(view.rendered, tally->answer.instance);
  FREEGS_ASSIGN_OR_RETURN(const double iou, semantics::MaskIou(truth, found));
  FREEGS_ASSIGN_OR_RETURN(const double boundary_iou,
                          semantics::BoundaryIou(truth, found));
  tally->ious.push_back(iou);
  tally->boundary_ious.push_back(boundary_iou);
  return Status();
}

// The IoU of the label's box that fits best; nothing when the label has no box.
std::optional<double> BoxIouOf(
    const LabelTally& tally,
    const std::vector<semantics::Instance>& instances) {
  if (tally.boxes.empty()) return std::nullopt;
  const auto instance = static_cast<size_t>(tally.answer.instance);
  if (tally.answer.instance < 0 || instance >= instances.size()) return 0;
  double best = 0;
  for (const semantics::AxisAlignedBox& box : tally.boxes) {
    best = std::max(best, semantics::BoxIou(box, instances[instance].aabb));
  }
  return best;
}

TextQuality Summarise(const LabelTallies& tallies,
                      const std::vector<semantics::Instance>& instances) {
  TextQuality quality;
  for (const auto& [label, tally] : tallies) {
    LabelResult result;
    result.label = label;
    result.num_objects = static_cast<int>(tally.objects.size());
    result.num_views = static_cast<int>(tally.ious.size());
    result.answer = tally.answer;
    result.iou = MeanOrNothing(tally.ious);
    result.boundary_iou = MeanOrNothing(tally.boundary_ious);
    result.box_iou = BoxIouOf(tally, instances);
    quality.labels.push_back(std::move(result));
  }
  SummariseLabels(&quality);
  return quality;
}

}  // namespace

void SummariseLabels(TextQuality* quality) {
  std::vector<double> ious;
  std::vector<double> boundary_ious;
  std::vector<double> box_ious;
  for (const LabelResult& label : quality->labels) {
    if (label.iou) ious.push_back(*label.iou);
    if (label.boundary_iou) boundary_ious.push_back(*label.boundary_iou);
    if (label.box_iou) box_ious.push_back(*label.box_iou);
  }
  quality->miou = MeanOrNothing(ious);
  quality->mbiou = MeanOrNothing(boundary_ious);
  quality->boxes = SummariseBoxes(box_ious);
}

std::set<std::string> Labels(const std::vector<TrueObject>& objects) {
  std::set<std::string> labels;
  for (const TrueObject& object : objects) {
    if (!object.label.empty()) labels.insert(object.label);
  }
  return labels;
}

StatusOr<std::optional<TextQuality>> MeasureTextQuality(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian,
    const std::map<std::string, TextAnswer>& answers) {
  LabelTallies tallies = Prepare(context.truth.objects, answers);
  if (tallies.empty()) return std::optional<TextQuality>();
  FREEGS_RETURN_IF_ERROR(
      context.ForEachView(instance_of_gaussian, [&](const JudgedView& view) {
        for (auto& [label, tally] : tallies) {
          const Status status = AddView(view, &tally);
          if (!status.ok()) return status.Annotated(view.name);
        }
        return Status();
      }));
  TextQuality quality =
      Summarise(tallies, InstancesInTruth(context, instance_of_gaussian));
  if (!quality.miou && !quality.boxes) return std::optional<TextQuality>();
  return std::optional(std::move(quality));
}

}  // namespace freegs::stages
