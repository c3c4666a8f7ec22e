// SPDX-License-Identifier: BSD-3-Clause
// Observations far from their points, and points without depth.

#include "sfm/scene/track_filter.h"

#include <limits>
#include <vector>

#include "sfm/scene/reconstruction_measures.h"

namespace freegs::sfm {
namespace {

constexpr double kMaxErrorPx = 4.0;  // COLMAP's threshold.
constexpr double kMinAngleDeg = 1.5;

}  // namespace

size_t FilterTracks(Reconstruction* model) {
  const auto image_index = IndexImages(*model);
  const auto camera_index = IndexCameras(*model);
  size_t removed = 0;
  const auto forget = [&](const TrackElement& element) {
    model->images[image_index.at(element.image_id)]
        .points2d[element.point2d_index]
        .point3d_id = kNoPoint3D;
    ++removed;
  };
  std::erase_if(model->points3d, [&](Point3D& point) {
    double sum = 0;
    std::vector<Eigen::Vector3d> centres;
    std::erase_if(point.track, [&](const TrackElement& element) {
      const PosedImage& image = model->images[image_index.at(element.image_id)];
      const auto pixel =
          Project(model->cameras[camera_index.at(image.camera_id)],
                  image.cam_from_world * point.xyz);
      const double error =
          pixel ? (*pixel - image.points2d[element.point2d_index].xy).norm()
                : std::numeric_limits<double>::infinity();
      if (!(error <= kMaxErrorPx)) {
        forget(element);
        return true;
      }
      sum += error;
      centres.push_back(CameraCentre(image.cam_from_world));
      return false;
    });
    if (point.track.size() < 2 ||
        TriangulationAngleDeg(point.xyz, centres) < kMinAngleDeg) {
      for (const TrackElement& element : point.track) forget(element);
      return true;
    }
    point.error = sum / static_cast<double>(point.track.size());
    return false;
  });
  return removed;
}

}  // namespace freegs::sfm
