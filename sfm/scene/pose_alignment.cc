// SPDX-License-Identifier: BSD-3-Clause
// Similarity alignment of named cameras.

#include "sfm/scene/pose_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/decompositions.h"
#include "core/quantile.h"

namespace freegs::sfm {
namespace {

// Centres count as collinear when their spread across the main direction is
// below this share of the spread along it.
constexpr double kMinSpreadRatio = 1e-3;

struct Centred {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3Xd offsets;
  double variance = 0;  // Mean squared distance from the mean.
};

Centred Centre(const std::vector<Eigen::Vector3d>& points) {
  Centred result;
  for (const auto& point : points) result.mean += point;
  result.mean /= static_cast<double>(points.size());
  result.offsets.resize(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) {
    result.offsets.col(static_cast<Eigen::Index>(i)) = points[i] - result.mean;
  }
  result.variance =
      result.offsets.squaredNorm() / static_cast<double>(points.size());
  return result;
}

Status CheckSpread(const Centred& source, const Centred& target) {
  if (!std::isfinite(source.variance) || !std::isfinite(target.variance)) {
    return BadInputError("a camera centre is not a number");
  }
  const auto coincide = [](const Centred& points) {
    return points.variance <= 1e-24 * (1 + points.mean.squaredNorm());
  };
  if (coincide(source) || coincide(target)) {
    return BadInputError("the points to be aligned are all at one place");
  }
  return {};
}

bool AreCollinear(const Centred& points) {
  // Eigenvalues of the scatter matrix are the squares of the spreads along the
  // principal axes; they come in ascending order.
  const Eigen::Matrix3d scatter = points.offsets * points.offsets.transpose();
  const Eigen::Vector3d spreads = DecomposeSymmetric(scatter).values;
  return spreads(1) < kMinSpreadRatio * kMinSpreadRatio * spreads(2);
}

// Scale and translation for a known rotation, by least squares.
Sim3d CompleteSimilarity(const Eigen::Matrix3d& rotation,
                         const Centred& source,
                         const Centred& target) {
  Sim3d result;
  result.rotation = Eigen::Quaterniond(rotation).normalized();
  const double overlap =
      (target.offsets.array() * (rotation * source.offsets).array()).sum();
  result.scale = overlap / source.offsets.squaredNorm();
  result.translation = target.mean - result.scale * (rotation * source.mean);
  return result;
}

double AngleDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond d = a.conjugate() * b;
  return 2 * std::atan2(d.vec().norm(), std::abs(d.w())) * 180 /
         std::numbers::pi;
}

}  // namespace

StatusOr<PoseAlignment> AlignPoses(const NamedPoses& source,
                                   const NamedPoses& target) {
  struct Common {
    const std::string* name;
    const Rigid3d* source;
    const Rigid3d* target;
  };
  std::vector<Common> common;
  std::vector<Eigen::Vector3d> source_centres;
  std::vector<Eigen::Vector3d> target_centres;
  for (const auto& [name, pose] : source) {
    const auto it = target.find(name);
    if (it == target.end()) continue;
    common.push_back({&name, &pose, &it->second});
    source_centres.push_back(CameraCentre(pose));
    target_centres.push_back(CameraCentre(it->second));
  }
  if (common.size() < 3) {
    return BadInputError("only " + std::to_string(common.size()) +
                         " camera names are in both sets of poses; alignment "
                         "needs three");
  }

  const Centred from = Centre(source_centres);
  const Centred to = Centre(target_centres);
  FREEGS_RETURN_IF_ERROR(CheckSpread(from, to));
  Eigen::Matrix3d covariance;
  if (AreCollinear(from) || AreCollinear(to)) {
    covariance.setZero();
    for (const Common& pair : common) {
      covariance += (pair.target->rotation.conjugate() * pair.source->rotation)
                        .toRotationMatrix();
    }
  } else {
    covariance = to.offsets * from.offsets.transpose();
  }

  PoseAlignment result;
  result.target_from_source =
      CompleteSimilarity(NearestRotation(covariance), from, to);
  if (!(result.target_from_source.scale > 0)) {
    return BadInputError("the two sets of poses do not fit each other");
  }
  std::vector<double> rotations;
  std::vector<double> distances;
  for (size_t i = 0; i < common.size(); ++i) {
    const Rigid3d moved =
        TransformCamera(result.target_from_source, *common[i].source);
    rotations.push_back(AngleDeg(moved.rotation, common[i].target->rotation));
    distances.push_back(
        (result.target_from_source * source_centres[i] - target_centres[i])
            .norm());
    result.residuals.push_back(
        {*common[i].name, rotations.back(), distances.back()});
  }
  result.median_rotation_deg = Median(rotations);
  result.max_rotation_deg =
      *std::max_element(rotations.begin(), rotations.end());
  result.median_centre = Median(distances);
  result.max_centre = *std::max_element(distances.begin(), distances.end());
  return result;
}

}  // namespace freegs::sfm
