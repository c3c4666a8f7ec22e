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

// The least variances that noise is taken to have, because less is lost in the
// rounding of what is computed here. That of a centre is relative to the
// squares of the spread and of the distance from the origin; that of an
// orientation is in square radians.
constexpr double kSpreadRounding = 1e-14;
constexpr double kOriginRounding = 1e-30;
constexpr double kAngleRounding = 1e-15;

// Orientations contradict the centres when the rotation that they pull to is
// more standard deviations than this from that of the centres.
constexpr double kMaxDeviations = 3;

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

// The rotation on which centres and orientations agree best.
// `relative_rotations` is the sum of the cameras' own target-from-source
// rotations.
//
// Both say how likely a rotation R is: the centres by their distances, and the
// orientations by the angle between R and their mean. Each counts by its own
// noise. Centres on a ring determine R better by far. Centres near a line
// determine all but the roll about the line, which the orientations determine
// then. For both, the logarithm of the likelihood is tr(R^T M) with some matrix
// M, plus a constant. So R is the nearest rotation to the sum of both matrices.
Eigen::Matrix3d EstimateRotation(const Centred& source,
                                 const Centred& target,
                                 const Eigen::Matrix3d& relative_rotations) {
  const auto count = static_cast<double>(source.offsets.cols());
  const Eigen::Matrix3d covariance =
      target.offsets * source.offsets.transpose();
  const auto fit = [&covariance](const Eigen::Matrix3d& rotation) {
    return rotation.cwiseProduct(covariance).sum();
  };
  const Eigen::Matrix3d by_centres = NearestRotation(covariance);
  const double best_fit = fit(by_centres);
  if (!(best_fit > 0)) return by_centres;
  const double scale = best_fit / source.offsets.squaredNorm();
  const double least_residual = kSpreadRounding * target.offsets.squaredNorm() +
                                kOriginRounding * count *
                                    (target.mean.squaredNorm() +
                                     scale * scale * source.mean.squaredNorm());
  // The sum of the squared distances between the centres, with the best scale
  // and translation for the rotation.
  const auto residual = [&](const Eigen::Matrix3d& rotation) {
    const double overlap = std::max(fit(rotation), 0.0);
    return std::max(least_residual,
                    target.offsets.squaredNorm() -
                        overlap * overlap / source.offsets.squaredNorm());
  };
  // A similarity takes 7 of the 3 count coordinates.
  const double centre_variance = residual(by_centres) / (3 * count - 7);

  // The variance of the mean orientation about each axis, in square radians.
  // Its first part is how much the cameras differ among each other. It is not
  // divided by their number, because the cameras of one model share errors. The
  // second part is how far the mean is from what the centres say, where they do
  // say something. It is large for poses of another convention of axes.
  const Eigen::Matrix3d by_orientations = NearestRotation(relative_rotations);
  const double scatter =
      1 - by_orientations.cwiseProduct(relative_rotations).sum() / (3 * count);
  const double offset = 1 - fit(by_orientations) / best_fit;
  const double angle_variance = std::max(kAngleRounding, scatter + offset);

  const Eigen::Matrix3d by_both =
      NearestRotation(scale / centre_variance * covariance +
                      0.5 / angle_variance * by_orientations);
  // A rotation that is z standard deviations away adds z^2 variances.
  const double added = residual(by_both) - residual(by_centres);
  return added <= kMaxDeviations * kMaxDeviations * centre_variance
             ? by_both
             : by_centres;
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
  Eigen::Matrix3d relative_rotations = Eigen::Matrix3d::Zero();
  for (const Common& pair : common) {
    relative_rotations +=
        (pair.target->rotation.conjugate() * pair.source->rotation)
            .toRotationMatrix();
  }

  PoseAlignment result;
  result.target_from_source = CompleteSimilarity(
      EstimateRotation(from, to, relative_rotations), from, to);
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
