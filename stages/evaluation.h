// SPDX-License-Identifier: BSD-3-Clause
// A workspace's scene against the truth. docs/evaluation.md is the protocol.

#ifndef FREEGS_STAGES_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/boxes.h"
#include "semantics/instances.h"
#include "sfm/pose_alignment.h"
#include "stages/ground_truth.h"
#include "stages/workspace_scene.h"

namespace freegs::stages {

struct EvaluationOptions {
  // Objects with fewer pixels in a view are not judged there.
  int min_mask_pixels = 30;

  // How boxes are put around instances: as in bootstrap/instances.json.
  semantics::InstanceBoxOptions boxes;

  Status Check() const;
};

// Picture quality of a set of views, means over views.
struct ImageQuality {
  struct ViewQuality {
    std::string name;
    double psnr = 0;  // dB.
    double ssim = 0;
  };
  double psnr = 0;
  double ssim = 0;
  std::vector<ViewQuality> views;
};

// An object of the truth and the instance that answers to it.
struct ObjectResult {
  int id = 0;
  std::string label;
  int num_views = 0;  // Test views in which it is judged.

  // The instance of highest IoU over all test views together, as in
  // idsf.bin; -1 without one.
  int instance = -1;

  // Means over its views: IoU of the view's best instance, and of the instance
  // clicked.
  std::optional<double> instance_iou;
  std::optional<double> click_iou;

  // Of the boxes, axis-aligned in the truth's frame; `box` is the instance's.
  std::optional<double> box_iou;
  std::optional<semantics::AxisAlignedBox> box;
};

struct InstanceQuality {
  // Means over all pairs of view and object.
  std::optional<double> instance_miou;
  std::optional<double> click_miou;
  // Over all objects of the truth.
  std::optional<double> box_miou;
  std::optional<double> box_recall25;
  std::optional<double> box_recall50;
  std::vector<ObjectResult> objects;
};

// Aligns the workspace's cameras with the truth's training cameras of the same
// name: equal, or, for those without, equal but for folder and suffix. The
// result maps the workspace's world to the truth's. kBadInput with fewer than
// three in common.
StatusOr<sfm::PoseAlignment> AlignWithTruth(const WorkspaceScene& scene,
                                            const GroundTruth& truth);

// The truth's views as cameras of the workspace's world.
std::vector<View> MapViews(const std::vector<View>& truth_views,
                           const Sim3d& truth_from_scene);

// Renders the holdout photographs of photos_folder at the size of training.
// Nothing without holdout photographs.
StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const std::filesystem::path& photos_folder,
    ThreadPool& pool);

// Renders the truth's test views at their full size and compares with its
// photographs. Nothing when it has none; kInterrupted when cancelled.
StatusOr<std::optional<ImageQuality>> MeasureTestQuality(
    const WorkspaceScene& scene,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const CancellationToken& cancellation,
    ThreadPool& pool);

// instance_of_gaussian: one value per Gaussian of the scene, negative = none.
// Nothing when the truth has no instance maps of test views. kInterrupted when
// cancelled.
StatusOr<std::optional<InstanceQuality>> MeasureInstanceQuality(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const EvaluationOptions& options,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_H_
