// SPDX-License-Identifier: BSD-3-Clause
// What a workspace knows about its scene, for those that render it again.

#ifndef FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_
#define FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

struct WorkspaceScene {
  splat::GaussianModel model;

  // The photographs of undistort/ at their own size, those that training saw
  // and those kept from it, each in the order of the sparse model.
  std::vector<View> train;
  std::vector<View> holdout;

  // Longest side in pixels of the images the model was trained on; 0 is the
  // photographs' own size. From reconstruct/stage.json, 0 without one.
  int training_max_side = 0;

  // With the background the model was trained on.
  splat::RenderOptions render;
};

// Reads undistort/, reconstruct/ and, for the split, ingest/ (all photographs
// count as training photographs without it). kBadInput names the file that is
// missing or malformed and the stage that writes it.
StatusOr<WorkspaceScene> ReadWorkspaceScene(
    const std::filesystem::path& workspace);

// Only the model: the same without cameras.
StatusOr<splat::GaussianModel> ReadWorkspaceModel(
    const std::filesystem::path& workspace);

// A file name with the extension `suffix` (".png") for each view: its own name
// with the extension replaced, or, where that would give two views the same
// file, with the suffix appended. kBadInput when a name is empty, absolute or
// leaves the folder it is put in ("../x").
StatusOr<std::vector<std::string>> OutputNames(const std::vector<View>& views,
                                               const std::string& suffix);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_
