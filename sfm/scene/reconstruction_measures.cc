// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/reconstruction_measures.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/quantile.h"
#include "sfm/scene/two_views.h"

namespace freegs::sfm {
namespace {

// All pairs of rays are compared. Of a longer track so many rays, evenly spread
// over it, stand for all.
constexpr size_t kMaxRays = 256;

}  // namespace

double TriangulationAngleDeg(const Eigen::Vector3d& point,
                             const std::vector<Eigen::Vector3d>& centres) {
  std::vector<Eigen::Vector3d> rays;
  const size_t count = std::min(centres.size(), kMaxRays);
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d ray = centres[i * centres.size() / count] - point;
    if (ray.norm() > 0) rays.push_back(ray.normalized());
  }
  double largest = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    for (size_t j = i + 1; j < rays.size(); ++j) {
      largest = std::max(largest, RayAngleDeg(rays[i], rays[j]));
    }
  }
  return largest;
}

ReconstructionMeasures MeasureReconstruction(const Reconstruction& model) {
  ReconstructionMeasures measures;
  const auto image_index = IndexImages(model);
  const auto camera_index = IndexCameras(model);
  double error_sum = 0;
  std::vector<double> lengths;
  std::vector<double> angles;
  for (const Point3D& point : model.points3d) {
    std::vector<Eigen::Vector3d> centres;
    for (const TrackElement& element : point.track) {
      const auto it = image_index.find(element.image_id);
      if (it == image_index.end()) continue;
      const PosedImage& image = model.images[it->second];
      if (element.point2d_index >= image.points2d.size()) continue;
      centres.push_back(CameraCentre(image.cam_from_world));
      const auto projected =
          Project(model.cameras[camera_index.at(image.camera_id)],
                  image.cam_from_world * point.xyz);
      if (!projected) {
        ++measures.behind;
        continue;
      }
      error_sum +=
          (*projected - image.points2d[element.point2d_index].xy).norm();
      ++measures.observations;
    }
    if (centres.size() < 2) continue;
    lengths.push_back(static_cast<double>(centres.size()));
    angles.push_back(TriangulationAngleDeg(point.xyz, centres));
  }
  measures.num_points = model.points3d.size();
  if (measures.observations > 0) {
    measures.mean_reprojection_error_px =
        error_sum / static_cast<double>(measures.observations);
  }
  measures.median_track_length = Median(std::move(lengths));
  measures.median_triangulation_deg = Median(std::move(angles));
  return measures;
}

}  // namespace freegs::sfm
