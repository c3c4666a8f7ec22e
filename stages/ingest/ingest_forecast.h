// SPDX-License-Identifier: BSD-3-Clause
// What stage ingest is going to need.

#ifndef FREEGS_STAGES_INGEST_INGEST_FORECAST_H_
#define FREEGS_STAGES_INGEST_INGEST_FORECAST_H_

#include <filesystem>
#include <string>
#include <vector>

#include "photos/photo_decode.h"
#include "photos/photo_list.h"
#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"

namespace freegs::stages {

// The photos among the files of a folder as their headers describe them. Only
// names, sizes and `converted` are set. Files that stage ingest would refuse
// are left out. Duplicates are not detected.
std::vector<photos::Photo> ReadPhotoHeaders(
    const std::filesystem::path& folder,
    const std::vector<std::string>& files,
    const photos::PhotoDecodeOptions& options);

// Appends the usable photos of the list to the scene. The files lie in
// `folder`.
void AddPhotosTo(const std::vector<photos::Photo>& photos,
                 const std::filesystem::path& folder,
                 pipeline::SceneOutlook* scene);

// What stage ingest needs for the photos of the scene.
pipeline::StageNeed IngestNeed(const pipeline::SceneOutlook& scene,
                               int threads);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_FORECAST_H_
