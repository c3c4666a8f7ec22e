// SPDX-License-Identifier: BSD-3-Clause
// Gathers what the report says from the JSON and CSV files of a workspace.

#ifndef FREEGS_STAGES_EXPORT_REPORT_DATA_H_
#define FREEGS_STAGES_EXPORT_REPORT_DATA_H_

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "stages/export/report_page.h"

namespace freegs::stages {

// The name of the figure that GatherReportData leaves empty: the caller knows
// the number of instances.
inline constexpr char kInstancesFigure[] = "Instances";

// Fills in title, figures, warnings, training curves, stages and the number of
// withheld words; views, instances and files stay empty. A file that is missing
// or malformed leaves its figures empty: a report is written in any case.
// `num_gaussians` is that of reconstruct/point_cloud.ply. Where somebody put
// another scene there, the figures of the training are not about it: they are
// left out, and a warning says so.
ReportData GatherReportData(const std::filesystem::path& workspace,
                            size_t num_gaussians);

// Whether reconstruct/point_cloud.ply is not the one that the stage wrote. As
// elsewhere in the program, the size of the file tells.
bool IsSceneReplaced(const std::filesystem::path& workspace);

struct ViewFigures {
  std::optional<double> psnr;  // dB.
  std::optional<double> ssim;
};

// Reads the figures of the holdout views, by name, from
// reconstruct/metrics.json. The map is empty when that file cannot be read, or
// when the scene is another one.
std::map<std::string, ViewFigures> ReadHoldoutFigures(
    const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_REPORT_DATA_H_
