// SPDX-License-Identifier: BSD-3-Clause
// Cameras and pictures of a workspace's scene against the truth; the protocol
// is in docs/evaluation.md.

#ifndef FREEGS_STAGES_EVALUATION_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_EVALUATION_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

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

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_EVALUATION_H_
