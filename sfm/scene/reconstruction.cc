// SPDX-License-Identifier: BSD-3-Clause
// Consistency and parts of a sparse reconstruction.

#include "sfm/scene/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "core/io/files.h"
#include "core/number_text.h"

namespace freegs::sfm {
namespace {

template <typename Id, typename Item>
std::unordered_map<Id, size_t> IndexById(const std::vector<Item>& items) {
  std::unordered_map<Id, size_t> index;
  index.reserve(items.size());
  for (size_t i = 0; i < items.size(); ++i) index.emplace(items[i].id, i);
  return index;
}

bool IsTooFar(const Eigen::Vector3d& position) {
  return position.cwiseAbs().maxCoeff() > kMaxCoordinate;
}

std::string TooFar() {
  return " is farther than " + FormatSignificant(kMaxCoordinate, 6) +
         " from the origin; choose another unit";
}

}  // namespace

std::unordered_map<uint32_t, size_t> IndexCameras(const Reconstruction& model) {
  return IndexById<uint32_t>(model.cameras);
}

std::unordered_map<uint32_t, size_t> IndexImages(const Reconstruction& model) {
  return IndexById<uint32_t>(model.images);
}

std::unordered_map<uint64_t, size_t> IndexPoints(const Reconstruction& model) {
  return IndexById<uint64_t>(model.points3d);
}

Status CheckReconstruction(const Reconstruction& model) {
  const auto cameras = IndexCameras(model);
  if (cameras.size() != model.cameras.size()) {
    return BadInputError("two cameras have the same id");
  }
  for (const Camera& camera : model.cameras) {
    FREEGS_RETURN_IF_ERROR(camera.Check());
  }

  if (IndexImages(model).size() != model.images.size()) {
    return BadInputError("two images have the same id");
  }
  std::unordered_set<std::string_view> names;
  for (const PosedImage& image : model.images) {
    const std::string where = "image '" + image.name + "'";
    if (image.name.empty()) return BadInputError("an image has no name");
    if (!IsNameBelowFolder(image.name)) {
      return BadInputError(where +
                           " does not name a file below the photo folder; "
                           "names must be relative to it and without '..'");
    }
    if (!names.insert(image.name).second) {
      return BadInputError(where + " appears twice");
    }
    if (!cameras.contains(image.camera_id)) {
      return BadInputError(where + " refers to camera " +
                           std::to_string(image.camera_id) +
                           ", which does not exist");
    }
    const Rigid3d& pose = image.cam_from_world;
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite() ||
        std::abs(pose.rotation.norm() - 1) > 1e-3) {
      return BadInputError(where +
                           " has a pose that is not a rotation and "
                           "translation");
    }
    if (IsTooFar(pose.translation)) {
      return BadInputError(where + TooFar());
    }
    for (const Point2D& point : image.points2d) {
      if (!point.xy.allFinite()) {
        return BadInputError(where + " has a feature that is not a number");
      }
    }
  }

  if (IndexPoints(model).size() != model.points3d.size()) {
    return BadInputError("two points have the same id");
  }
  for (const Point3D& point : model.points3d) {
    if (point.id == kNoPoint3D) {
      return BadInputError("a point has the id that stands for no point");
    }
    if (!point.xyz.allFinite() || !std::isfinite(point.error)) {
      return BadInputError("point " + std::to_string(point.id) +
                           " is not a number");
    }
    if (IsTooFar(point.xyz)) {
      return BadInputError("point " + std::to_string(point.id) + TooFar());
    }
  }
  return {};
}

size_t RemoveDanglingReferences(Reconstruction* model) {
  const auto images = IndexImages(*model);
  size_t removed = 0;
  // The point of each feature as its track says.
  std::vector<std::vector<uint64_t>> owners(model->images.size());
  for (size_t i = 0; i < model->images.size(); ++i) {
    owners[i].assign(model->images[i].points2d.size(), kNoPoint3D);
  }
  for (Point3D& point : model->points3d) {
    removed += std::erase_if(point.track, [&](const TrackElement& element) {
      const auto it = images.find(element.image_id);
      if (it == images.end()) return true;
      const PosedImage& image = model->images[it->second];
      if (element.point2d_index >= image.points2d.size()) return true;
      if (image.points2d[element.point2d_index].point3d_id != point.id) {
        return true;
      }
      uint64_t& owner = owners[it->second][element.point2d_index];
      if (owner == point.id) return true;  // Listed twice.
      owner = point.id;
      return false;
    });
  }
  for (size_t i = 0; i < model->images.size(); ++i) {
    std::vector<Point2D>& features = model->images[i].points2d;
    for (size_t k = 0; k < features.size(); ++k) {
      if (features[k].point3d_id == owners[i][k]) continue;
      features[k].point3d_id = kNoPoint3D;
      ++removed;
    }
  }
  return removed;
}

Reconstruction RestrictTo(const Reconstruction& model,
                          const std::vector<uint32_t>& image_ids) {
  const std::set<uint32_t> kept(image_ids.begin(), image_ids.end());
  Reconstruction part;
  std::set<uint32_t> cameras;
  for (const PosedImage& image : model.images) {
    if (!kept.contains(image.id)) continue;
    part.images.push_back(image);
    cameras.insert(image.camera_id);
  }
  for (const Camera& camera : model.cameras) {
    if (cameras.contains(camera.id)) part.cameras.push_back(camera);
  }
  for (const Point3D& point : model.points3d) {
    Point3D seen = point;
    std::erase_if(seen.track, [&](const TrackElement& element) {
      return !kept.contains(element.image_id);
    });
    std::set<uint32_t> observers;
    for (const TrackElement& e : seen.track) observers.insert(e.image_id);
    if (observers.size() >= 2) part.points3d.push_back(std::move(seen));
  }
  RemoveDanglingReferences(&part);
  return part;
}

}  // namespace freegs::sfm
