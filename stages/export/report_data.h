// SPDX-License-Identifier: BSD-3-Clause
// What the report says, gathered from the JSON and CSV files of a workspace.

#ifndef FREEGS_STAGES_EXPORT_REPORT_DATA_H_
#define FREEGS_STAGES_EXPORT_REPORT_DATA_H_

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "stages/export/report_page.h"

namespace freegs::stages {

// The figure that is left empty for the number of instances.
inline constexpr char kInstancesFigure[] = "Instances";

// Title, figures, warnings, training curves and stages. Views, instances and
// files are left empty. Files that are missing or malformed leave their figures
// empty; nothing fails.
ReportData GatherReportData(const std::filesystem::path& workspace);

// PSNR and SSIM of the holdout views by name, from reconstruct/metrics.json.
struct ViewFigures {
  std::optional<double> psnr;
  std::optional<double> ssim;
};
std::map<std::string, ViewFigures> ReadHoldoutFigures(
    const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_REPORT_DATA_H_
