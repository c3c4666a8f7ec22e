// SPDX-License-Identifier: BSD-3-Clause
// Compares a scene's instances with the true objects, without regard to names;
// the protocol is in docs/evaluation.md.

#ifndef FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"
#include "semantics/geometry/boxes.h"
#include "semantics/instances/instances.h"
#include "semantics/metrics/panoptic_quality.h"
#include "semantics/metrics/segmentation_balance.h"
#include "stages/evaluation/evaluation_context.h"

namespace freegs::stages {

// An object of the truth and the instance that is compared with it.
struct ObjectResult {
  int id = 0;
  std::string label;
  int num_views = 0;  // Test views in which it is judged.

  // The label (as in idsf.bin) of the instance with the highest IoU over all
  // test views together; for an object that no mask shows, of the instance
  // whose box has the highest IoU. -1 when no instance overlaps the object.
  int instance = -1;

  // Means over the object's views: the IoU of the view's best instance, and the
  // IoU of the instance at the innermost pixel of the object's mask.
  std::optional<double> instance_iou;
  std::optional<double> click_iou;

  // The IoU of the boxes, axis-aligned in the truth's frame, and the box of the
  // instance.
  std::optional<double> box_iou;
  std::optional<semantics::AxisAlignedBox> box;
};

// Summary of the IoUs of boxes: their mean, and the shares of boxes that reach
// an IoU of 0.25 and of 0.5.
struct BoxQuality {
  double miou = 0;
  double recall25 = 0;
  double recall50 = 0;
};

// Returns nothing for an empty list.
std::optional<BoxQuality> SummariseBoxes(const std::vector<double>& ious);

struct InstanceQuality {
  // Means over all pairs of view and object.
  std::optional<double> instance_miou;
  std::optional<double> click_miou;
  // Over all objects of the truth that have a box.
  std::optional<BoxQuality> boxes;
  // Over all test views together; empty without masks.
  std::optional<semantics::SegmentationBalance> balance;
  // Panoptic quality of each view, and of all views together. Both are empty
  // when the truth is not complete (GroundTruth::complete).
  std::vector<std::pair<std::string, semantics::PanopticQuality>> panoptic;
  semantics::PanopticQuality panoptic_sum;
  std::vector<ObjectResult> objects;
};

// The mean of the values; nothing for an empty list.
std::optional<double> MeanOrNothing(const std::vector<double>& values);

// Puts boxes around the instances in the truth's frame; element k belongs to
// label k. `instance_of_gaussian` has one label per Gaussian of the scene,
// negative for none.
std::vector<semantics::Instance> InstancesInTruth(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian);

// Compares the instances with the truth. `instance_of_gaussian` has one label
// per Gaussian of the scene, negative for none. The result is empty when the
// truth has neither masks of test views nor boxes. The errors are those of
// EvaluationContext::ForEachView.
StatusOr<std::optional<InstanceQuality>> MeasureInstanceQuality(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_
