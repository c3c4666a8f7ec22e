// SPDX-License-Identifier: BSD-3-Clause
// The pictures of one view in the report.

#ifndef FREEGS_STAGES_EXPORT_REPORT_VIEWS_H_
#define FREEGS_STAGES_EXPORT_REPORT_VIEWS_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "stages/scene/depth_image.h"
#include "stages/export/report_page.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// `count` of the views, evenly spread; all when there are not more.
std::vector<View> SpreadViews(const std::vector<View>& views, int count);

// 4 x the mean absolute difference of the channels, as grey. Both H x W x 3 of
// the same size.
ImageU8 DifferenceImage(const ImageU8& a, const ImageU8& b);

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
