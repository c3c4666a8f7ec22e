// SPDX-License-Identifier: BSD-3-Clause
// Reads the truth about a scene from a folder in any known layout.
//
//   FREEGS_ASSIGN_OR_RETURN(GroundTruth truth, ReadTruth("teatime", "auto"));

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

// The names of the layouts: "scene" (stages/evaluation/ground_truth.h),
// "lerf_mask" (lerf_mask.h), "3dovs" (three_d_ovs.h), "scannet" (scannet.h).
std::vector<std::string> LayoutNames();

// Recognises the layout of `folder` by what lies in it, in this order:
//   scene      gt/cameras.json or cameras.json
//   lerf_mask  test_mask/
//   3dovs      segmentations/
//   scannet    pose/ with *.aggregation.json or *_vh_clean_2.labels.ply
// Returns nothing when none of these exists.
std::optional<std::string> DetectLayout(const std::filesystem::path& folder);

// Reads the truth in `folder`. `layout` is one of LayoutNames(), or "auto",
// which recognises it. kBadInput when "auto" recognises none, kInvalidArgument
// for an unknown name; the other errors are those of the layout's reader.
StatusOr<GroundTruth> ReadTruth(const std::filesystem::path& folder,
                                const std::string& layout);

// Gives each of truth->unposed the camera that the workspace has for the
// photograph of this name, and the lens of that photograph (sfm/sparse/0), on
// which the masks were drawn. Afterwards the truth's frame is the workspace's.
// Returns the names for which the workspace has no posed photograph; kBadInput
// when it has none for all of them.
StatusOr<std::vector<std::string>> TakeWorkspaceCameras(
    const std::filesystem::path& workspace,
    const WorkspaceScene& scene,
    GroundTruth* truth);

// Returns the names of the test views with masks or photographs that the scene
// was trained on. Figures measured on these views say little about new views.
std::vector<std::string> TrainedOn(const WorkspaceScene& scene,
                                   const GroundTruth& truth);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_LAYOUT_H_
