// SPDX-License-Identifier: BSD-3-Clause
// The greedy choice of photos, and the model of only these.

#include "sfm/calibration/photo_sample.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace freegs::sfm {
namespace {

// A point that so many images of the sample see needs no more of them.
constexpr int kEnoughObservations = 4;

// So many images of each camera are taken before others.
constexpr int kImagesPerCamera = 3;

// The points that each image sees, as positions in model.points3d.
std::vector<std::vector<size_t>> PointsOfImages(const Reconstruction& model) {
  const auto index = IndexImages(model);
  std::vector<std::vector<size_t>> points(model.images.size());
  for (size_t p = 0; p < model.points3d.size(); ++p) {
    for (const TrackElement& element : model.points3d[p].track) {
      points[index.at(element.image_id)].push_back(p);
    }
  }
  return points;
}

// Whether each image is in the sample.
std::vector<bool> ChooseImages(const Reconstruction& model, size_t max_images) {
  const std::vector<std::vector<size_t>> points = PointsOfImages(model);
  const auto camera_index = IndexCameras(model);
  std::vector<int> wanted(model.cameras.size(), kImagesPerCamera);
  std::vector<int> seen(model.points3d.size(), 0);
  std::vector<bool> chosen(model.images.size(), false);
  for (size_t count = 0; count < max_images; ++count) {
    // Whether its camera wants it, what it gains, and how many points it sees.
    using Worth = std::pair<bool, std::pair<size_t, size_t>>;
    Worth best_worth;
    size_t best = model.images.size();
    for (size_t i = 0; i < model.images.size(); ++i) {
      if (chosen[i]) continue;
      size_t gain = 0;
      for (const size_t p : points[i]) {
        gain += seen[p] > 0 && seen[p] < kEnoughObservations;
      }
      const size_t camera = camera_index.at(model.images[i].camera_id);
      const Worth worth = {wanted[camera] > 0, {gain, points[i].size()}};
      if (best == model.images.size() || worth > best_worth) {
        best = i;
        best_worth = worth;
      }
    }
    chosen[best] = true;
    --wanted[camera_index.at(model.images[best].camera_id)];
    for (const size_t p : points[best]) ++seen[p];
  }
  return chosen;
}

}  // namespace

Reconstruction SamplePhotos(const Reconstruction& model, size_t max_images) {
  if (model.images.size() <= max_images) return model;
  const std::vector<bool> chosen = ChooseImages(model, max_images);
  const auto index = IndexImages(model);
  Reconstruction sample;
  sample.cameras = model.cameras;
  for (const Point3D& point : model.points3d) {
    Point3D copy = point;
    std::erase_if(copy.track, [&](const TrackElement& element) {
      return !chosen[index.at(element.image_id)];
    });
    if (copy.track.size() >= 2) sample.points3d.push_back(std::move(copy));
  }
  for (size_t i = 0; i < model.images.size(); ++i) {
    if (chosen[i]) sample.images.push_back(model.images[i]);
  }
  RemoveDanglingReferences(&sample);
  return sample;
}

}  // namespace freegs::sfm
