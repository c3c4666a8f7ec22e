// SPDX-License-Identifier: BSD-3-Clause
// A sparse reconstruction: cameras, posed images and triangulated points, with
// the fields of COLMAP's model files.

#ifndef FREEGS_SFM_SCENE_RECONSTRUCTION_H_
#define FREEGS_SFM_SCENE_RECONSTRUCTION_H_

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "core/rigid3d.h"
#include "core/status.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// Cameras and points lie within this of the origin, in whatever unit. Squares
// of distances stay far from the largest float.
inline constexpr double kMaxCoordinate = 1e12;

inline constexpr uint64_t kNoPoint3D = std::numeric_limits<uint64_t>::max();

// A feature of an image, and the point that it shows, if any.
struct Point2D {
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  // Pixels.
  uint64_t point3d_id = kNoPoint3D;
};

// An image with a pose.
struct PosedImage {
  uint32_t id = 0;
  uint32_t camera_id = 0;
  std::string name;  // Relative to the photo folder, '/' between folders.
  Rigid3d cam_from_world;
  std::vector<Point2D> points2d;
};

// One observation of a point: feature `point2d_index` of image `image_id`.
struct TrackElement {
  uint32_t image_id = 0;
  uint32_t point2d_index = 0;
};

struct Point3D {
  uint64_t id = 0;
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  std::array<uint8_t, 3> rgb = {0, 0, 0};
  double error = -1;  // Mean reprojection error in pixels; < 0 is unknown.
  std::vector<TrackElement> track;
};

// Cameras, posed images and points:
//
//   FREEGS_ASSIGN_OR_RETURN(const Reconstruction model, ReadModel(folder));
//   const auto cameras = IndexCameras(model);
//   for (const PosedImage& image : model.images) {
//     const Camera& camera = model.cameras[cameras.at(image.camera_id)];
//     const auto pixel = Project(camera, image.cam_from_world * point);
//   }
//
// Each list has the order of the file that it was read from, and writing keeps
// this order.
struct Reconstruction {
  std::vector<Camera> cameras;
  std::vector<PosedImage> images;
  std::vector<Point3D> points3d;
};

// The position of each element in its list, by id.
std::unordered_map<uint32_t, size_t> IndexCameras(const Reconstruction& model);
std::unordered_map<uint32_t, size_t> IndexImages(const Reconstruction& model);
std::unordered_map<uint64_t, size_t> IndexPoints(const Reconstruction& model);

// Returns kBadInput for repeated ids or image names, for image names that lead
// out of the photo folder, for images without a camera, for numbers that are
// not finite, and for cameras and points beyond kMaxCoordinate.
Status CheckReconstruction(const Reconstruction& model);

// Makes tracks and features agree: drops track elements that name no existing
// feature, and clears features whose point is missing or does not list them.
// Models that other tools edited often need this. Returns how many references
// were removed. `model` must pass CheckReconstruction.
size_t RemoveDanglingReferences(Reconstruction* model);

// A copy of the model with these images only, their cameras, and the points
// that at least two of them observe.
Reconstruction RestrictTo(const Reconstruction& model,
                          const std::vector<uint32_t>& image_ids);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_RECONSTRUCTION_H_
