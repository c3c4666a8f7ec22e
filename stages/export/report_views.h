// SPDX-License-Identifier: BSD-3-Clause
// Writes the pictures of one view for the report.

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

// Renders `view` at the size of training, in the exposure in which
// metrics.json measures it (InExposureOf), and writes folder/PREFIX_photo.jpg,
// PREFIX_render.jpg, PREFIX_difference.jpg, PREFIX_depth.jpg and, when `labels`
// has one label per Gaussian and is not empty, PREFIX_instances.jpg. The paths
// of the result are relative to the folder's parent. A photo that cannot be
// read leaves `photo` and `difference` empty.
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
