// SPDX-License-Identifier: BSD-3-Clause
// The options of stage export.

#ifndef FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_
#define FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_

#include "pipeline/option_table.h"

namespace freegs::stages {

struct ExportStageOptions {
  // So many training views, evenly spread, get masks besides the holdout views.
  int mask_views = 8;

  // So many views are shown in the report.
  int report_views = 6;
};

// Adds section [export] to the table, which keeps pointers to `options`.
void RegisterExportOptions(ExportStageOptions& options,
                           pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_
