// SPDX-License-Identifier: BSD-3-Clause
// A scene's instances against the truth, whatever they are called; the protocol
// is in docs/evaluation.md.

#ifndef FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/geometry/boxes.h"
#include "semantics/instances/instances.h"
#include "semantics/metrics/panoptic_quality.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct EvaluationOptions {
  // Objects with fewer pixels in a view are not judged there.
  int min_mask_pixels = 30;

  // Longest side in pixels at which masks are compared; larger ones are
  // reduced.
  int max_mask_side = 1600;

  // How boxes are put around instances: as in bootstrap/instances.json.
  semantics::InstanceBoxOptions boxes = {};

  Status Check() const;
};

// An object of the truth and the instance that answers to it.
struct ObjectResult {
  int id = 0;
  std::string label;
  int num_views = 0;  // Test views in which it is judged.

  // The instance of highest IoU over all test views together, as in
  // idsf.bin; -1 without one. Where the truth has no masks at all, the instance
  // whose box fits best.
  int instance = -1;

  // Means over its views: IoU of the view's best instance, and of the instance
  // clicked.
  std::optional<double> instance_iou;
  std::optional<double> click_iou;

  // Of the boxes, axis-aligned in the truth's frame; `box` is the instance's.
  std::optional<double> box_iou;
  std::optional<semantics::AxisAlignedBox> box;
};

// IoU of boxes: their mean, and the shares that reach 0.25 and 0.5.
struct BoxQuality {
  double miou = 0;
  double recall25 = 0;
  double recall50 = 0;
};

// Nothing without any.
std::optional<BoxQuality> SummariseBoxes(const std::vector<double>& ious);

struct InstanceQuality {
  // Means over all pairs of view and object.
  std::optional<double> instance_miou;
  std::optional<double> click_miou;
  // Over all objects of the truth that have a box.
  std::optional<BoxQuality> boxes;
  // By view, and over all; empty when the truth is not complete.
  std::vector<std::pair<std::string, semantics::PanopticQuality>> panoptic;
  semantics::PanopticQuality panoptic_sum;
  std::vector<ObjectResult> objects;
};

// The mean, nothing of nothing.
std::optional<double> MeanOrNothing(const std::vector<double>& values);

// The box of each instance in the truth's frame: element k is instance k's.
// instance_of_gaussian: one value per Gaussian of the model, negative = none.
std::vector<semantics::Instance> InstancesInTruth(
    const splat::GaussianModel& model,
    std::span<const int32_t> instance_of_gaussian,
    const Sim3d& truth_from_scene,
    const semantics::InstanceBoxOptions& options,
    ThreadPool& pool);

// instance_of_gaussian as above. Nothing when the truth has neither masks of
// test views nor boxes. Errors as ForEachJudgedView.
StatusOr<std::optional<InstanceQuality>> MeasureInstanceQuality(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const EvaluationOptions& options,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_INSTANCE_EVALUATION_H_
