// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/importance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "core/quantile.h"

namespace freegs::splat {
namespace {

constexpr double kFarFactor = 5;
constexpr double kFarShare = 0.1;
constexpr double kNearQuantile = 0.25;

Eigen::Vector3d MedianPoint(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d median;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    median[axis] = LowerQuantile(values, 0.5);
  }
  return median;
}

// The distances that are finite.
std::vector<double> Distances(const Eigen::Vector3d& from,
                              const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    const double distance = (point - from).norm();
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  return distances;
}

}  // namespace

ImportanceAccumulator::ImportanceAccumulator(size_t num_gaussians)
    : indoor_(num_gaussians),
      outdoor_(num_gaussians),
      ever_dominant_(num_gaussians) {}

void ImportanceAccumulator::AddView(const ViewContributions& contributions) {
  for (size_t k = 0; k < contributions.model_index.size(); ++k) {
    const uint32_t i = contributions.model_index[k];
    const double weight = contributions.weight_sum[k];
    if (!(weight > 0 && std::isfinite(weight))) continue;
    indoor_[i] += weight;
    if (contributions.num_dominant[k] == 0) continue;
    ever_dominant_[i] = 1;
    outdoor_[i] += weight / std::max(1u, contributions.num_pixels[k]);
  }
}

std::vector<float> ImportanceAccumulator::Importance(
    ImportanceMetric metric) const {
  const std::vector<double>& sums =
      metric == ImportanceMetric::kIndoor ? indoor_ : outdoor_;
  std::vector<float> importance(sums.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    if (ever_dominant_[i] != 0) importance[i] = static_cast<float>(sums[i]);
  }
  return importance;
}

ImportanceMetric ChooseImportanceMetric(std::span<const View> views,
                                        const GaussianModel& model) {
  std::vector<Eigen::Vector3d> centres;
  for (const View& view : views) {
    const Eigen::Vector3d centre = CameraCentre(view.cam_from_world);
    if (centre.allFinite()) centres.push_back(centre);
  }
  if (centres.empty()) return ImportanceMetric::kIndoor;
  const Eigen::Vector3d middle = MedianPoint(centres);
  std::vector<Eigen::Vector3d> means(model.size());
  for (size_t i = 0; i < means.size(); ++i) {
    means[i] = Eigen::Vector3f::Map(&model.means[3 * i]).cast<double>();
  }
  const std::vector<double> distances = Distances(middle, means);
  if (distances.empty()) return ImportanceMetric::kIndoor;

  const double length = std::max(LowerQuantile(Distances(middle, centres), 0.5),
                                 LowerQuantile(distances, kNearQuantile));
  const auto num_far =
      std::count_if(distances.begin(), distances.end(), [&](double distance) {
        return distance > kFarFactor * length;
      });
  return static_cast<double>(num_far) >=
                 kFarShare * static_cast<double>(distances.size())
             ? ImportanceMetric::kOutdoor
             : ImportanceMetric::kIndoor;
}

}  // namespace freegs::splat
