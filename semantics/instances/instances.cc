// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "core/decompositions.h"
#include "core/kd_tree.h"
#include "core/quantile.h"

namespace freegs::semantics {
namespace {

// The cosine of 30 degrees: what leans more does not tell the vertical.
constexpr double kMinVerticalCosine = 0.5 * std::numbers::sqrt3;

constexpr int kIsolationNeighbors = 8;
// So many points are enough to find the best angle of a box. Its sides use all
// points.
constexpr size_t kMaxAnglePoints = 4000;

struct WeightedPoint {
  Eigen::Vector3d position;
  double weight;
  Eigen::Matrix3d root;  // root * root^T is the covariance.
};

// Standard deviation of the Gaussian along a unit vector.
double Sigma(const WeightedPoint& point, const Eigen::Vector3d& direction) {
  // Dot products, as a product of Eigen's is rounded in another way with each
  // instruction set.
  Eigen::Vector3d along;
  for (int k = 0; k < 3; ++k) along[k] = point.root.col(k).dot(direction);
  return along.norm();
}

// The interval along a direction that leaves `trim` of the weight outside on
// each side. A Gaussian reaches one standard deviation to either side, about as
// far as an opaque Gaussian hides what is behind it.
std::pair<double, double> TrimmedRange(const std::vector<WeightedPoint>& points,
                                       const Eigen::Vector3d& direction,
                                       double trim,
                                       size_t stride = 1) {
  std::vector<std::pair<double, double>> lows;   // (end, weight)
  std::vector<std::pair<double, double>> highs;  // (-end, weight)
  double total = 0;
  for (size_t i = 0; i < points.size(); i += stride) {
    const double middle = direction.dot(points[i].position);
    const double sigma = Sigma(points[i], direction);
    lows.emplace_back(middle - sigma, points[i].weight);
    highs.emplace_back(-(middle + sigma), points[i].weight);
    total += points[i].weight;
  }
  const auto end = [&](std::vector<std::pair<double, double>>& ends) {
    // Only the few outermost are wanted in order.
    std::make_heap(ends.begin(), ends.end(), std::greater<>());
    double outside = 0;
    while (ends.size() > 1 && outside + ends.front().second <= trim * total) {
      outside += ends.front().second;
      std::pop_heap(ends.begin(), ends.end(), std::greater<>());
      ends.pop_back();
    }
    return ends.front().first;
  };
  return {end(lows), -end(highs)};
}

OrientedBox BoxAlong(const std::vector<WeightedPoint>& points,
                     const Eigen::Matrix3d& axes,
                     double trim) {
  // The centre is summed up here, for the reason given in Sigma.
  OrientedBox box;
  box.rotation = axes;
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = TrimmedRange(points, axes.col(k), trim);
    box.centre += (low + high) / 2 * axes.col(k);
    box.size[k] = high - low;
  }
  return box;
}

Eigen::Matrix3d UprightAxes(const std::vector<WeightedPoint>& points,
                            const Eigen::Vector3d& vertical,
                            double trim) {
  const Eigen::Vector3d u = vertical.unitOrthogonal();
  const Eigen::Vector3d v = vertical.cross(u);
  const size_t stride = points.size() / kMaxAnglePoints + 1;
  double best_area = 0;
  Eigen::Matrix3d best;
  for (int degree = 0; degree < 90; ++degree) {
    const double angle = degree * std::numbers::pi / 180;
    const Eigen::Vector3d a = std::cos(angle) * u + std::sin(angle) * v;
    const Eigen::Vector3d b = vertical.cross(a);
    const auto [a_low, a_high] = TrimmedRange(points, a, trim, stride);
    const auto [b_low, b_high] = TrimmedRange(points, b, trim, stride);
    const double area = (a_high - a_low) * (b_high - b_low);
    if (degree == 0 || area < best_area) {
      best_area = area;
      best << a, b, vertical;
    }
  }
  return best;
}

Eigen::Matrix3d BoxAxes(const std::vector<WeightedPoint>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const WeightedPoint& point : points) mean += point.position;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (const WeightedPoint& point : points) {
    const Eigen::Vector3d offset = point.position - mean;
    moment += offset * offset.transpose();
  }
  Eigen::Matrix3d axes = DecomposeSymmetric(moment).vectors;
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  return axes;
}

// Rotation times scales; zero where that is not finite.
Eigen::Matrix3d CovarianceRoot(const splat::GaussianModel& model, uint32_t i) {
  const float* q = model.rotations.data() + i * size_t{4};
  const float* s = model.log_scales.data() + i * size_t{3};
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d scales(std::exp(s[0]), std::exp(s[1]), std::exp(s[2]));
  const Eigen::Matrix3d root =
      rotation.normalized().toRotationMatrix() * scales.asDiagonal();
  return root.allFinite() ? root : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
}

std::vector<WeightedPoint> WithoutStrays(
    const std::vector<WeightedPoint>& points, double max_isolation) {
  if (points.size() <= 2 * kIsolationNeighbors) return points;
  std::vector<float> positions;
  positions.reserve(points.size() * 3);
  for (const WeightedPoint& point : points) {
    for (int k = 0; k < 3; ++k) {
      positions.push_back(static_cast<float>(point.position[k]));
    }
  }
  const auto tree = KdTree::Build(positions, 3);
  if (!tree.ok()) return points;
  std::vector<double> isolation(points.size());
  std::vector<Neighbor> neighbors;
  for (uint32_t i = 0; i < points.size(); ++i) {
    tree->Nearest(
        positions.data() + i * size_t{3}, kIsolationNeighbors, i, &neighbors);
    isolation[i] = neighbors.back().distance2;
  }
  const double limit = UpperMedian(isolation) * max_isolation * max_isolation;
  std::vector<WeightedPoint> kept;
  for (size_t i = 0; i < points.size(); ++i) {
    if (isolation[i] <= limit) kept.push_back(points[i]);
  }
  return kept;
}

}  // namespace

std::vector<Instance> BuildInstances(
    const splat::GaussianModel& model,
    std::span<const int32_t> labels,
    int num_labels,
    std::span<const double> scores,
    std::span<const uint8_t> background,
    const std::optional<Eigen::Vector3d>& vertical,
    const InstanceBoxOptions& options,
    ThreadPool& pool) {
  std::vector<std::vector<uint32_t>> members(num_labels);
  for (uint32_t i = 0; i < labels.size(); ++i) {
    if (labels[i] >= 0 && labels[i] < num_labels) {
      members[labels[i]].push_back(i);
    }
  }
  std::vector<Instance> instances(num_labels);
  pool.ParallelFor(0, num_labels, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t label = first; label < last; ++label) {
      Instance& instance = instances[label];
      instance.id = static_cast<int>(label) + 1;
      instance.num_gaussians = static_cast<int64_t>(members[label].size());
      if (static_cast<size_t>(label) < scores.size()) {
        instance.score = scores[label];
      }
      if (static_cast<size_t>(label) < background.size()) {
        instance.background = background[label] != 0;
      }
      std::vector<WeightedPoint> all;
      std::vector<WeightedPoint> solid;
      for (const uint32_t i : members[label]) {
        const Eigen::Vector3d position(model.means[i * size_t{3}],
                                       model.means[i * size_t{3} + 1],
                                       model.means[i * size_t{3} + 2]);
        if (!position.allFinite()) continue;
        const double opacity = splat::Opacity(model, i);
        all.push_back({position, opacity, CovarianceRoot(model, i)});
        if (opacity >= options.min_opacity) solid.push_back(all.back());
      }
      if (solid.empty()) solid = all;
      if (solid.empty()) continue;
      const std::vector<WeightedPoint> points =
          WithoutStrays(solid, options.max_isolation);
      double weight = 0;
      for (const WeightedPoint& point : points) {
        instance.centre += point.weight * point.position;
        weight += point.weight;
      }
      instance.centre /= weight;
      const OrientedBox aligned =
          BoxAlong(points, Eigen::Matrix3d::Identity(), options.trim);
      instance.aabb = {aligned.centre - aligned.size / 2,
                       aligned.centre + aligned.size / 2};
      instance.obb =
          BoxAlong(points,
                   vertical ? UprightAxes(points, *vertical, options.trim)
                            : BoxAxes(points),
                   options.trim);
    }
  });
  return instances;
}

Eigen::Vector3d BentToLevelCameras(std::span<const View> views,
                                   const Eigen::Vector3d& up) {
  // The given direction counts as much as x axes do that fan out by 4 degrees.
  constexpr double kWeightOfUp = 0.005;
  // Which x axes are level shows only when the direction is about right.
  constexpr int kRounds = 3;
  Eigen::Vector3d bent = up.normalized();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    for (const View& view : views) {
      const Eigen::Vector3d right =
          view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitX();
      matrix += kWeightOfUp * Eigen::Matrix3d::Identity();
      if (std::abs(right.dot(bent)) < 0.5) matrix += right * right.transpose();
    }
    bent = matrix.ldlt().solve(up).normalized();
  }
  return bent;
}

std::optional<Eigen::Vector3d> EstimateVertical(std::span<const View> views,
                                                std::span<const Plane> planes) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const View& view : views) {
    sum += view.cam_from_world.rotation.conjugate() * -Eigen::Vector3d::UnitY();
  }
  if (views.empty() || sum.norm() < 0.3 * static_cast<double>(views.size())) {
    return std::nullopt;
  }
  const Eigen::Vector3d up = BentToLevelCameras(views, sum);
  for (const Plane& plane : planes) {
    const double cosine = plane.normal.dot(up);
    if (std::abs(cosine) > kMinVerticalCosine) {
      return cosine > 0 ? plane.normal : Eigen::Vector3d(-plane.normal);
    }
  }
  return up;
}

std::optional<Eigen::Vector3d> VerticalOfBoxes(
    std::span<const View> views, std::span<const Instance> instances) {
  const std::optional<Eigen::Vector3d> rough = EstimateVertical(views, {});
  if (!rough || instances.empty()) return rough;
  const Eigen::Matrix3d& axes = instances.front().obb.rotation;
  int vertical = 0;
  double cosine = 0;
  for (int k = 0; k < 3; ++k) {
    const double of_axis = std::abs(axes.col(k).dot(*rough));
    if (!(of_axis > cosine)) continue;
    cosine = of_axis;
    vertical = k;
  }
  if (!(cosine > kMinVerticalCosine)) return rough;
  const Eigen::Vector3d axis = axes.col(vertical);
  return axis.dot(*rough) > 0 ? axis : Eigen::Vector3d(-axis);
}

}  // namespace freegs::semantics
