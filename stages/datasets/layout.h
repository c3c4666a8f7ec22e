// SPDX-License-Identifier: BSD-3-Clause
// Which data set's layout a folder of truth has.

#ifndef FREEGS_STAGES_DATASETS_LAYOUT_H_
#define FREEGS_STAGES_DATASETS_LAYOUT_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Names of the layouts: "scene" (ground_truth.h), "lerf_mask" (lerf_mask.h),
// "3dovs" (three_d_ovs.h), "scannet" (scannet.h).
std::vector<std::string> LayoutNames();

// The layout of `folder` by what lies in it: gt/cameras.json or cameras.json,
// test_mask/, segmentations/, pose/ with *.aggregation.json or
// *_vh_clean_2.labels.ply, in this order; nothing when none of them does.
std::optional<std::string> DetectLayout(const std::filesystem::path& folder);

// Reads the truth in `folder`; layout is one of LayoutNames(), or "auto".
// kBadInput when "auto" finds none; otherwise as the layout's reader.
StatusOr<GroundTruth> ReadTruth(const std::filesystem::path& folder,
                                const std::string& layout);

// Gives the truth's unposed test views the cameras of the workspace's own
// photographs of these names, and the lens (sfm/sparse/0) of their masks. The
// truth's frame is the workspace's afterwards. Returns the names without a
// posed photograph; kBadInput when all are.
StatusOr<std::vector<std::string>> TakeWorkspaceCameras(
    const std::filesystem::path& workspace,
    const WorkspaceScene& scene,
    GroundTruth* truth);

// Test views of the truth that the scene was trained on, by the names of its
// photographs: measuring on them says little.
std::vector<std::string> TrainedOn(const WorkspaceScene& scene,
                                   const GroundTruth& truth);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_LAYOUT_H_
