// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/workspace_scene.h"

#include <cstdlib>
#include <map>
#include <system_error>
#include <utility>

#include "core/io/files.h"
#include "pipeline/stage_record.h"
#include "splat/scene/ply_io.h"
#include "stages/scene/exposure_file.h"
#include "stages/scene/training_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// kBadInput, naming the stage, when a file of that stage is missing.
Status RequireStageFile(const fs::path& workspace,
                        const std::string& stage,
                        const fs::path& file) {
  std::error_code error;
  const fs::path path = workspace / stage / file;
  if (fs::exists(path, error)) return Status();
  return BadInputError(path.string() + ": no such file or folder; run stage " +
                       stage + " first");
}

// Before this version the stage wrote the transpose of each matrix.
constexpr int kExposuresAsIn3dgs = 14;

splat::AffineColor Transposed(const splat::AffineColor& color) {
  splat::AffineColor result = color;
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column) {
      result.values[4 * row + column] = color.values[4 * column + row];
    }
  }
  return result;
}

// Takes what the record of the training says about it.
void TakeTrainingRecord(const fs::path& workspace, WorkspaceScene* scene) {
  const StatusOr<pipeline::StageRecord> record =
      pipeline::ReadStageRecord(workspace / "reconstruct");
  if (!record.ok()) return;  // Somebody else's model.
  const auto& options = record->fingerprint.options;
  const auto max_side = options.find("reconstruct.max_image_size");
  if (max_side != options.end()) {
    scene->training_max_side = std::atoi(max_side->second.c_str());
  }
  const auto background = options.find("reconstruct.background");
  if (background != options.end() && background->second == "white") {
    scene->render.background = {1, 1, 1};
  }
  if (record->fingerprint.version < kExposuresAsIn3dgs) {
    for (splat::PhotoExposure& exposure : scene->exposures) {
      exposure.color = Transposed(exposure.color);
    }
  }
}

}  // namespace

StatusOr<splat::PlacedModel> ReadWorkspaceModel(const fs::path& workspace) {
  FREEGS_RETURN_IF_ERROR(
      RequireStageFile(workspace, "reconstruct", "point_cloud.ply"));
  return splat::ReadPly(workspace / "reconstruct" / "point_cloud.ply");
}

StatusOr<WorkspaceScene> ReadWorkspaceScene(const fs::path& workspace) {
  FREEGS_ASSIGN_OR_RETURN(PosedPhotos posed, ReadPosedPhotos(workspace));
  WorkspaceScene scene;
  scene.train = std::move(posed.train);
  scene.holdout = std::move(posed.holdout);
  scene.without_pose = std::move(posed.without_pose);
  scene.frame = posed.frame;
  FREEGS_ASSIGN_OR_RETURN(const splat::PlacedModel model,
                          ReadWorkspaceModel(workspace));
  scene.model = splat::ToFrame(model, scene.frame);
  if (!scene.model.AllFinite()) {
    return BadInputError(
        (workspace / "reconstruct" / "point_cloud.ply").string() +
        ": Gaussians are too large, or too far from the cameras of undistort/, "
        "for float32");
  }
  FREEGS_ASSIGN_OR_RETURN(
      scene.exposures,
      ReadExposures(workspace / "reconstruct" / "exposure.json"));
  TakeTrainingRecord(workspace, &scene);
  return scene;
}

Image<int32_t> RenderLabels(const WorkspaceScene& scene,
                            const View& view,
                            std::span<const int32_t> labels,
                            ThreadPool& pool) {
  return splat::RenderLabels(scene.model,
                             view.camera,
                             view.cam_from_world,
                             scene.render,
                             pool,
                             labels);
}

StatusOr<std::vector<std::string>> OutputNames(const std::vector<View>& views,
                                               const std::string& suffix) {
  std::vector<std::string> names;
  std::vector<std::string>
      whole_names;  // "./a.jpg" is the same file as "a.jpg".
  for (const View& view : views) {
    if (!IsNameBelowFolder(view.name)) {
      return BadInputError("view \"" + view.name +
                           "\": not a file name inside a folder");
    }
    whole_names.push_back(fs::path(view.name).lexically_normal().string());
    names.push_back(
        fs::path(whole_names.back()).replace_extension(suffix).string());
  }
  // A whole name can be what another view has without its extension, so this is
  // repeated until no name changes.
  for (bool changed = true; changed;) {
    changed = false;
    std::map<std::string, int> uses;
    for (const std::string& name : names) ++uses[name];
    for (size_t i = 0; i < names.size(); ++i) {
      const std::string whole = whole_names[i] + suffix;
      if (uses[names[i]] == 1 || names[i] == whole) continue;
      names[i] = whole;
      changed = true;
    }
  }
  std::map<std::string, std::string> view_of;
  for (size_t i = 0; i < names.size(); ++i) {
    const auto [other, is_new] = view_of.emplace(names[i], views[i].name);
    if (is_new) continue;
    return BadInputError("views \"" + other->second + "\" and \"" +
                         views[i].name + "\" would have the same file");
  }
  // Without a suffix they are names of folders, which may lie in each other.
  if (suffix.empty()) return names;
  for (const std::string& name : names) {
    for (fs::path folder = fs::path(name).parent_path(); !folder.empty();
         folder = folder.parent_path()) {
      const auto file = view_of.find(folder.string());
      if (file == view_of.end()) continue;
      return BadInputError("view \"" + file->second +
                           "\" would be a folder of \"" + view_of.at(name) +
                           "\", too");
    }
  }
  return names;
}

StatusOr<std::map<std::string, std::string>> OutputNameByView(
    const std::vector<View>& views, const std::string& suffix) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(views, suffix));
  std::map<std::string, std::string> by_view;
  for (size_t i = 0; i < views.size(); ++i) by_view[views[i].name] = names[i];
  return by_view;
}

}  // namespace freegs::stages
