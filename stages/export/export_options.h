// SPDX-License-Identifier: BSD-3-Clause
// The options of stage export.

#ifndef FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_
#define FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_

namespace freegs::stages {

struct ExportStageOptions {
  // So many training views, evenly spread, get masks besides the holdout views.
  int mask_views = 8;

  // So many views are shown in the report.
  int report_views = 6;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_EXPORT_OPTIONS_H_
