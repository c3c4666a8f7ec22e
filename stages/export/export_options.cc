// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/export_options.h"

namespace freegs::stages {

void RegisterExportOptions(ExportStageOptions& options,
                           pipeline::OptionTable& table) {
  table.AddSection("export",
                   "PLY files, masks, boxes and a report for other programs "
                   "and for people.");
  table.Add("export.mask_views",
            &options.mask_views,
            {.help = "Training photos, evenly spread, that get instance masks "
                     "besides the holdout photos.",
             .min = 0});
  table.Add("export.report_views",
            &options.report_views,
            {.help = "Photos shown in the report, evenly spread over the "
                     "holdout photos; without any, over the training photos.",
             .min = 0});
}

}  // namespace freegs::stages
