// SPDX-License-Identifier: BSD-3-Clause
// What stage bootstrap is going to need.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_FORECAST_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_FORECAST_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/pinhole.h"
#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"
#include "stages/bootstrap/bootstrap_options.h"

namespace freegs::stages {

// Views whose features are averaged, and in which instances are looked at.
inline constexpr size_t kMaxLiftedViews = 24;

// The views that teach. A few see all that an average needs; training (mode
// paper) takes all.
std::vector<View> Teachers(const BootstrapStageOptions& options,
                           const std::vector<View>& train);

// The need for the photos and Gaussians of the scene, with networks of a CLIP
// model that have so many bytes. Nothing is known without photos or Gaussians.
pipeline::StageNeed BootstrapNeed(const BootstrapStageOptions& options,
                                  int64_t model_bytes,
                                  int threads,
                                  const pipeline::SceneOutlook& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_FORECAST_H_
