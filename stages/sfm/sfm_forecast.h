// SPDX-License-Identifier: BSD-3-Clause
// What the stages sfm and undistort are going to need.

#ifndef FREEGS_STAGES_SFM_SFM_FORECAST_H_
#define FREEGS_STAGES_SFM_SFM_FORECAST_H_

#include <cstdint>
#include <filesystem>

#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"
#include "sfm/colmap/sfm_options.h"

namespace freegs::stages {

// The pairs that are expected to be matched of so many photos.
int64_t ExpectedPairs(const sfm::PairSelectionOptions& options, int64_t photos);

// The needs for the photos of the scene. Nothing is known without photos.
// SfmNeed also sets the scene's points, to what it expects to find.
pipeline::StageNeed SfmNeed(const sfm::SfmOptions& options,
                            int threads,
                            pipeline::SceneOutlook* scene);
// COLMAP's undistorter starts a thread for each of the machine's processors,
// also where it may use `cores` of them only.
pipeline::StageNeed UndistortNeed(const pipeline::SceneOutlook& scene,
                                  int cores,
                                  int processors);

// Sets photos and points to those of the model in a folder. A photo is of the
// holdout if it was before. Nothing is known of a model that cannot be read.
void SetSceneToModel(const std::filesystem::path& folder,
                     pipeline::SceneOutlook* scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_SFM_FORECAST_H_
