// SPDX-License-Identifier: BSD-3-Clause
// bootstrap/ -> export/: the results in forms that others use.

#ifndef FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_
#define FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_

#include <memory>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"

namespace freegs::stages {

struct ExportStageOptions {
  // Training views, evenly spread, that get masks besides the holdout views.
  int mask_views = 8;

  // Views shown in the report.
  int report_views = 6;
};

void RegisterExportOptions(ExportStageOptions& options,
                           pipeline::OptionTable& table);

// Reads undistort/, reconstruct/ and, if there, bootstrap/; for the report also
// what the other stages say about themselves. Writes (docs/outputs.md has the
// formats)
//   scene.ply, scene.splat      the Gaussians
//   instances.ply               in their instances' colours
//   masks/VIEW/ID.png           0 or 255, of the photo's size
//   boxes.json, boxes.ply       of the instances
//   report/index.html           a page about the result, and its pictures
// Without bootstrap/ there are no instances, masks or boxes.
std::unique_ptr<pipeline::Stage> MakeExportStage(
    const ExportStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_EXPORT_STAGE_H_
