// SPDX-License-Identifier: BSD-3-Clause
// Regroups the cameras of a reconstruction.

#include "sfm/calibration/camera_sharing.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sfm/scene/camera_conversion.h"

namespace freegs::sfm {
namespace {

// The key of an image. Images with equal keys share a camera.
using SharingKey = std::pair<uint64_t, uint64_t>;

// The keys of the images that a sharing leads to.
std::vector<SharingKey> SharingKeys(const Reconstruction& model,
                                    CameraSharing sharing) {
  const auto index = IndexCameras(model);
  std::vector<SharingKey> keys;
  for (const PosedImage& image : model.images) {
    const Camera& camera = model.cameras[index.at(image.camera_id)];
    switch (sharing) {
      case CameraSharing::kShared:
        keys.emplace_back(camera.width, camera.height);
        break;
      case CameraSharing::kPerGroup:
        keys.emplace_back(camera.id, 0);
        break;
      case CameraSharing::kPerPhoto:
        keys.emplace_back(image.id, 0);
        break;
    }
  }
  return keys;
}

// Gives images with equal keys one camera, that which most of them had.
void Regroup(const std::vector<SharingKey>& keys, Reconstruction* model) {
  const auto index = IndexCameras(*model);
  // Per new camera: its images, and how many of them had each old camera.
  std::map<SharingKey, std::vector<size_t>> groups;
  for (size_t i = 0; i < keys.size(); ++i) groups[keys[i]].push_back(i);
  std::vector<std::vector<size_t>> ordered;
  for (auto& [key, images] : groups) ordered.push_back(std::move(images));
  std::sort(ordered.begin(), ordered.end());  // By first image.

  uint32_t next_id = 0;
  for (const Camera& camera : model->cameras) {
    next_id = std::max(next_id, camera.id);
  }
  std::vector<Camera> cameras;
  std::vector<uint32_t> used;
  for (const std::vector<size_t>& images : ordered) {
    std::map<uint32_t, size_t> votes;
    for (const size_t i : images) ++votes[model->images[i].camera_id];
    const auto most = std::max_element(
        votes.begin(), votes.end(), [](const auto& a, const auto& b) {
          return a.second < b.second;
        });
    Camera camera = model->cameras[index.at(most->first)];
    camera.id = model->images[images[0]].camera_id;
    if (std::find(used.begin(), used.end(), camera.id) != used.end()) {
      camera.id = ++next_id;
    }
    used.push_back(camera.id);
    cameras.push_back(std::move(camera));
  }
  for (size_t g = 0; g < ordered.size(); ++g) {
    for (const size_t i : ordered[g])
      model->images[i].camera_id = cameras[g].id;
  }
  model->cameras = std::move(cameras);
}

}  // namespace

std::string_view CameraSharingName(CameraSharing sharing) {
  switch (sharing) {
    case CameraSharing::kShared:
      return "shared";
    case CameraSharing::kPerGroup:
      return "per_group";
    case CameraSharing::kPerPhoto:
      return "per_photo";
  }
  return "shared";
}

size_t NumCameras(const Reconstruction& model, CameraSharing sharing) {
  auto keys = SharingKeys(model, sharing);
  std::sort(keys.begin(), keys.end());
  return std::unique(keys.begin(), keys.end()) - keys.begin();
}

void AssignCameras(CameraModel camera_model,
                   CameraSharing sharing,
                   Reconstruction* model) {
  Regroup(SharingKeys(*model, sharing), model);
  for (Camera& camera : model->cameras) {
    camera = ConvertCamera(camera, camera_model);
  }
}

void NoteCameraGroups(const Reconstruction& model, CameraGroups* groups) {
  for (const PosedImage& image : model.images) {
    groups->emplace(image.name, image.camera_id);
  }
}

void RestoreCameraGroups(const CameraGroups& groups, Reconstruction* model) {
  std::vector<SharingKey> keys;
  for (const PosedImage& image : model->images) {
    const auto group = groups.find(image.name);
    keys.push_back(group == groups.end() ? SharingKey(image.camera_id, 1)
                                         : SharingKey(group->second, 0));
  }
  Regroup(keys, model);
}

}  // namespace freegs::sfm
