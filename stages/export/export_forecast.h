// SPDX-License-Identifier: BSD-3-Clause
// What stage export is going to need.

#ifndef FREEGS_STAGES_EXPORT_EXPORT_FORECAST_H_
#define FREEGS_STAGES_EXPORT_EXPORT_FORECAST_H_

#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"
#include "stages/export/export_options.h"

namespace freegs::stages {

// The need for the photos and Gaussians of the scene. Nothing is known without
// either.
pipeline::StageNeed ExportNeed(const ExportStageOptions& options,
                               int threads,
                               const pipeline::SceneOutlook& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_EXPORT_FORECAST_H_
