// SPDX-License-Identifier: BSD-3-Clause
// The pictures of one view in the report.

#ifndef FREEGS_STAGES_EXPORT_REPORT_VIEWS_H_
#define FREEGS_STAGES_EXPORT_REPORT_VIEWS_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "stages/export/report_page.h"
#include "stages/scene/depth_image.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Renders `view` at the size training used and writes photo, render,
// difference, depth and, when there are labels (one per Gaussian), instances to
// folder/PREFIX_photo.jpg and so on. The paths of the result are relative to
// the folder's parent. A photo that cannot be read leaves photo and difference
// empty.
StatusOr<ReportView> WriteReportView(const WorkspaceScene& scene,
                                     const View& view,
                                     const DepthRange& depth_range,
                                     std::span<const int32_t> labels,
                                     const std::filesystem::path& photo_path,
                                     const std::filesystem::path& folder,
                                     const std::string& prefix,
                                     ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_REPORT_VIEWS_H_
