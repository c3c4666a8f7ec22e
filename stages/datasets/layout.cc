// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/layout.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "sfm/import/name_matching.h"
#include "sfm/scene/model_io.h"
#include "stages/datasets/lerf_mask.h"
#include "stages/datasets/mask_folders.h"
#include "stages/datasets/scannet.h"
#include "stages/datasets/three_d_ovs.h"
#include "stages/evaluation/evaluation.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// For each name the index of the view that it means, -1 for none.
std::vector<int> MatchViews(const std::vector<std::string>& names,
                            const std::vector<View>& views) {
  std::vector<sfm::SfmPhoto> photos;
  for (const View& view : views) {
    sfm::SfmPhoto photo;
    photo.name = photo.file = view.name;
    photos.push_back(std::move(photo));
  }
  return sfm::MatchNames(names, photos).photos;
}

// The lenses that distort, by photograph, before undistortion. Empty when the
// workspace has no sfm/sparse/0.
StatusOr<std::map<std::string, sfm::Camera>> ReadLenses(
    const fs::path& workspace) {
  std::map<std::string, sfm::Camera> lenses;
  const fs::path folder = workspace / "sfm" / "sparse" / "0";
  if (!sfm::DetectModelFormat(folder)) return lenses;
  FREEGS_ASSIGN_OR_RETURN(const sfm::Reconstruction model,
                          sfm::ReadModel(folder));
  const auto camera_index = sfm::IndexCameras(model);
  for (const sfm::PosedImage& image : model.images) {
    const sfm::Camera& camera = model.cameras[camera_index.at(image.camera_id)];
    if (!camera.IsUndistorted()) lenses[image.name] = camera;
  }
  return lenses;
}

}  // namespace

std::vector<std::string> LayoutNames() {
  return {"scene", "lerf_mask", "3dovs", "scannet"};
}

std::optional<std::string> DetectLayout(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / "gt" / "cameras.json", error) ||
      fs::exists(folder / "cameras.json", error)) {
    return "scene";
  }
  if (fs::is_directory(folder / "test_mask", error)) return "lerf_mask";
  if (fs::is_directory(folder / "segmentations", error)) return "3dovs";
  const std::vector<std::string> files = FilesIn(folder);
  if (fs::is_directory(folder / "pose", error) &&
      std::any_of(files.begin(), files.end(), [](const std::string& file) {
        return file.ends_with(".aggregation.json") ||
               file.ends_with("_vh_clean_2.labels.ply");
      })) {
    return "scannet";
  }
  return std::nullopt;
}

StatusOr<GroundTruth> ReadTruth(const fs::path& folder,
                                const std::string& layout) {
  std::string name = layout;
  if (layout == "auto") {
    const std::optional<std::string> detected = DetectLayout(folder);
    if (!detected) {
      return BadInputError(
          folder.string() +
          ": no truth in a layout known here: gt/cameras.json (scene), "
          "test_mask/ (LERF-Mask), segmentations/ (3D-OVS), or pose/ and "
          "*.aggregation.json (ScanNet)");
    }
    name = *detected;
  }
  if (name == "scene") return ReadGroundTruth(folder);
  if (name == "lerf_mask") return ReadLerfMask(folder);
  if (name == "3dovs") return ReadThreeDOvs(folder);
  if (name == "scannet") return ReadScannet(folder);
  return InvalidArgumentError("\"" + layout + "\" is no layout of truth");
}

StatusOr<std::vector<std::string>> TakeWorkspaceCameras(
    const fs::path& workspace,
    const WorkspaceScene& scene,
    GroundTruth* truth) {
  FREEGS_ASSIGN_OR_RETURN(const auto lenses, ReadLenses(workspace));
  std::vector<View> views = scene.holdout;
  views.insert(views.end(), scene.train.begin(), scene.train.end());
  const std::vector<int> matches = MatchViews(truth->unposed, views);
  std::vector<std::string> missing;
  for (size_t i = 0; i < matches.size(); ++i) {
    const std::string& name = truth->unposed[i];
    if (matches[i] < 0) {
      missing.push_back(name);
      continue;
    }
    View view = views[static_cast<size_t>(matches[i])];
    const auto lens = lenses.find(view.name);
    if (lens != lenses.end()) truth->lenses[name] = lens->second;
    view.name = name;
    truth->cameras.test.push_back(std::move(view));
  }
  if (truth->cameras.test.empty()) {
    return BadInputError(truth->folder.string() +
                         ": the workspace has a pose for none of its test "
                         "views (" +
                         missing[0] + ", ...); was it made of these photos?");
  }
  truth->unposed.clear();
  return missing;
}

std::vector<std::string> TrainedOn(const WorkspaceScene& scene,
                                   const GroundTruth& truth) {
  const std::vector<TestViewUse> uses = FindTestViewUses(scene, truth);
  std::vector<std::string> trained;
  for (size_t i = 0; i < uses.size(); ++i) {
    const std::string& name = truth.cameras.test[i].name;
    if (uses[i] != TestViewUse::kTraining) continue;
    if (truth.masks.contains(name) || truth.photos.contains(name)) {
      trained.push_back(name);
    }
  }
  return trained;
}

}  // namespace freegs::stages
