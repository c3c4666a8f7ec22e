// SPDX-License-Identifier: BSD-3-Clause
// Projects the points of each photo into the other photos.

#include "sfm/lookalikes/missing_correspondences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/quantile.h"
#include "sfm/scene/two_views.h"

namespace freegs::sfm {
namespace {

// Beyond the last angle, occlusion and the limits of descriptors hide points
// too often.
constexpr std::array<double, 6> kAngles = {0, 5, 10, 15, 20, 30};
constexpr size_t kNumBins = kAngles.size() - 1;
constexpr size_t kMinPairs = 3;  // For the median of a bin.

constexpr double kMinClaimed = 20;
constexpr double kMaxDistanceRatio = 1.6;
constexpr double kBorder = 0.02;  // Share of the image that does not count.

// More points of a photo are sampled.
constexpr size_t kMaxPoints = 300;

struct Photo {
  uint32_t id = 0;
  const PosedImage* image = nullptr;
  const Camera* camera = nullptr;
  Eigen::Vector3d centre;
  std::vector<bool> observes;  // For each point.
  std::vector<size_t> points;  // A sample of those.
  double weight = 1;           // Points for which each of the sample stands.
  Eigen::Vector3d middle;      // Their mean.
};

std::vector<Photo> MakePhotos(const Reconstruction& model) {
  const auto camera_index = IndexCameras(model);
  const auto point_index = IndexPoints(model);
  std::vector<Photo> photos;
  for (const PosedImage& image : model.images) {
    Photo photo;
    photo.id = image.id;
    photo.image = &image;
    photo.camera = &model.cameras[camera_index.at(image.camera_id)];
    photo.centre = CameraCentre(image.cam_from_world);
    photo.observes.assign(model.points3d.size(), false);
    std::vector<size_t> points;
    for (const Point2D& feature : image.points2d) {
      const auto it = point_index.find(feature.point3d_id);
      if (it == point_index.end() || photo.observes[it->second]) continue;
      photo.observes[it->second] = true;
      points.push_back(it->second);
    }
    if (points.empty()) continue;
    const size_t step = (points.size() + kMaxPoints - 1) / kMaxPoints;
    photo.middle.setZero();
    for (size_t k = 0; k < points.size(); k += step) {
      photo.points.push_back(points[k]);
      photo.middle += model.points3d[points[k]].xyz;
    }
    const auto count = static_cast<double>(photo.points.size());
    photo.middle /= count;
    photo.weight = static_cast<double>(points.size()) / count;
    photos.push_back(std::move(photo));
  }
  std::sort(photos.begin(), photos.end(), [](const Photo& a, const Photo& b) {
    return a.id < b.id;
  });
  return photos;
}

bool IsInside(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto width = static_cast<double>(camera.width);
  const auto height = static_cast<double>(camera.height);
  return pixel.x() > kBorder * width && pixel.x() < (1 - kBorder) * width &&
         pixel.y() > kBorder * height && pixel.y() < (1 - kBorder) * height;
}

// How many points of one photo another one should see, and how many of these it
// does; with the angles between the rays, in degrees.
struct Claim {
  double claimed = 0;
  double shared = 0;
  std::vector<double> angles;
};

Claim Compare(const Reconstruction& model, const Photo& from, const Photo& to) {
  Claim claim;
  // A quick test: most pairs look from quite different sides.
  if (RayAngleDeg(from.centre - from.middle, to.centre - from.middle) >
      2 * kAngles.back()) {
    return claim;
  }
  for (const size_t k : from.points) {
    const Eigen::Vector3d& point = model.points3d[k].xyz;
    const Eigen::Vector3d ray1 = from.centre - point;
    const Eigen::Vector3d ray2 = to.centre - point;
    const double ratio = ray1.norm() / ray2.norm();
    if (!(ratio < kMaxDistanceRatio && ratio * kMaxDistanceRatio > 1)) continue;
    const auto pixel = Project(*to.camera, to.image->cam_from_world * point);
    if (!pixel || !IsInside(*to.camera, *pixel)) continue;
    claim.claimed += from.weight;
    if (to.observes[k]) claim.shared += from.weight;
    claim.angles.push_back(RayAngleDeg(ray1, ray2));
  }
  return claim;
}

size_t Bin(double angle) {
  size_t bin = 0;
  while (bin + 1 < kNumBins && angle >= kAngles[bin + 1]) ++bin;
  return bin;
}

// The share of points that is usual for pairs in each bin of angles (see the
// header).
std::array<double, kNumBins> UsualShares(const std::vector<SharedView>& views) {
  std::array<std::vector<double>, kNumBins> shares;
  for (const SharedView& view : views) {
    shares[Bin(view.angle_deg)].push_back(view.shared / view.claimed);
  }
  std::array<double, kNumBins> usual = {};
  double least = 0;
  for (size_t bin = kNumBins; bin-- > 0;) {
    if (shares[bin].size() >= kMinPairs) {
      least = std::max(least, UpperMedian(std::move(shares[bin])));
    }
    usual[bin] = least;
  }
  return usual;
}

}  // namespace

std::vector<SharedView> FindMissingCorrespondences(
    const Reconstruction& model,
    const std::set<std::pair<uint32_t, uint32_t>>& compared) {
  const std::vector<Photo> photos = MakePhotos(model);
  std::vector<SharedView> views;
  for (size_t i = 0; i < photos.size(); ++i) {
    for (size_t j = i + 1; j < photos.size(); ++j) {
      if (!compared.contains({photos[i].id, photos[j].id})) continue;
      const Claim there = Compare(model, photos[i], photos[j]);
      if (there.claimed < kMinClaimed) continue;
      const Claim back = Compare(model, photos[j], photos[i]);
      if (back.claimed < kMinClaimed) continue;
      SharedView view;
      view.image_id1 = photos[i].id;
      view.image_id2 = photos[j].id;
      view.angle_deg =
          (UpperMedian(there.angles) + UpperMedian(back.angles)) / 2;
      if (view.angle_deg >= kAngles.back()) continue;
      view.claimed = (there.claimed + back.claimed) / 2;
      view.shared = (there.shared + back.shared) / 2;
      views.push_back(view);
    }
  }
  const auto usual = UsualShares(views);
  for (SharedView& view : views) {
    view.missing =
        std::max(0.0, usual[Bin(view.angle_deg)] * view.claimed - view.shared);
  }
  return views;
}

}  // namespace freegs::sfm
