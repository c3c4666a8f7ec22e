// SPDX-License-Identifier: BSD-3-Clause
// Stage export, bootstrap/ -> export/: the results in forms that other programs
// and people use. MakeExportStage makes the stage;
// stages/registry/stage_registry.h shows who runs it.

#ifndef FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_
#define FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_

#include <memory>

#include "pipeline/stage.h"
#include "stages/export/export_options.h"

namespace freegs::stages {

// Reads undistort/, reconstruct/ and, if it exists, bootstrap/; for the report
// also the stage.json and other files of all stages. Writes (docs/outputs.md
// has the formats)
//   scene.ply, .splat, .spz     the Gaussians
//   instances.ply               the Gaussians in their instances' colours
//   masks/VIEW/ID.png           0 or 255, of the photo's size
//   boxes.json, boxes.ply       the boxes of the instances
//   report/index.html           a page about the result, with its pictures and
//                               the files of its 3D view
// Without bootstrap/ there are no instances, masks and boxes.
std::unique_ptr<pipeline::Stage> MakeExportStage(
    const ExportStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_
