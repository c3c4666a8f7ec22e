// SPDX-License-Identifier: BSD-3-Clause
// The finished scene of a workspace: the model, its cameras, and how to render
// it. Stage bootstrap, stage export and most commands begin with it:
//
//   FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
//                           ReadWorkspaceScene(workspace));
//   const splat::RenderedView picture =
//       splat::RenderView(scene.model, scene.train[0].camera,
//                         scene.train[0].cam_from_world, scene.render, pool);

#ifndef FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_
#define FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/optim/exposure.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"
#include "splat/scene/model_frame.h"

namespace freegs::stages {

struct WorkspaceScene {
  // The model and the views are in this frame (stages/scene/working_frame.h),
  // not in the world.
  splat::ModelFrame frame;

  splat::GaussianModel model;

  // The views of undistort/ at the photographs' own size: those that training
  // saw, and those it never saw. Each list is in the order of the names.
  std::vector<View> train;
  std::vector<View> holdout;

  // Names of photographs without a pose, as in PosedPhotos.
  std::vector<std::string> without_pose;

  // Longest side in pixels of the images that the model was trained on, from
  // reconstruct/stage.json. 0 means the photographs' own size. It is also the
  // value without that file, when somebody else put the model there.
  int training_max_side = 0;

  // Has the background colour that the model was trained with.
  splat::RenderOptions render;

  // What training learnt about the exposure of each photograph, in the order of
  // their names; empty where it did not.
  std::vector<splat::PhotoExposure> exposures;
};

// Reads undistort/, reconstruct/, and the split into training and holdout from
// ingest/. Without ingest/ all photographs count as training photographs.
// kBadInput names the file that is missing or malformed; for a missing one also
// the stage that writes it.
StatusOr<WorkspaceScene> ReadWorkspaceScene(
    const std::filesystem::path& workspace);

// Reads only the model, reconstruct/point_cloud.ply, in the world frame. Errors
// as above.
StatusOr<splat::PlacedModel> ReadWorkspaceModel(
    const std::filesystem::path& workspace);

// Returns the label with the largest blending weight at each pixel of `view`,
// as splat::RenderLabels does: -1 where labelled Gaussians cover less than half
// of the pixel. `labels` has one label per Gaussian of the scene, negative for
// none.
Image<int32_t> RenderLabels(const WorkspaceScene& scene,
                            const View& view,
                            std::span<const int32_t> labels,
                            ThreadPool& pool);

// Makes a file name with the extension `suffix` (".png") for each view; no two
// views may have the same name. It is the view's name with its extension
// replaced. Where two views would get the same file, the suffix is appended to
// the whole name instead. kBadInput when a name is empty, absolute, or leaves
// its folder ("../x"), when two names are the same file ("./x"), and, unless
// `suffix` is empty, when one would be a folder of another.
StatusOr<std::vector<std::string>> OutputNames(const std::vector<View>& views,
                                               const std::string& suffix);

// The file names that OutputNames makes, by the names of the views. A stage
// that writes files for some photographs of a scene asks for the names of all
// of them, so that a photograph has the same name in the output of every stage.
StatusOr<std::map<std::string, std::string>> OutputNameByView(
    const std::vector<View>& views, const std::string& suffix);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_WORKSPACE_SCENE_H_
