// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/depth_reinitialization.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "splat/density/simplification.h"

namespace freegs::splat {
namespace {

// The smallest standard deviation, as a share of the largest.
constexpr double kMinFlatness = 1e-6;

// sqrt(2 ln 255): the distance in standard deviations at which the alpha of an
// opaque Gaussian falls to 1/255.
constexpr double kReach = 3.329;

bool SameSize(const Pinhole& camera,
              const ViewContributions& contributions,
              const ImageF& photo) {
  const auto fits = [&](const auto& image, int channels) {
    return image.width() == camera.width && image.height() == camera.height &&
           image.channels() == channels;
  };
  return fits(contributions.dominant, 1) &&
         fits(contributions.transmittance, 1) && fits(photo, 3);
}

// The direction from the camera through the centre of a pixel, in the camera
// frame with z = 1.
Eigen::Vector3d CameraRay(const Pinhole& camera, int x, int y) {
  return {(x + 0.5 - camera.cx) / camera.fx,
          (y + 0.5 - camera.cy) / camera.fy,
          1.0};
}

}  // namespace

std::optional<double> MidpointDistance(const GaussianModel& model,
                                       size_t index,
                                       const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) {
  const Eigen::Vector3d mean =
      Eigen::Vector3f::Map(&model.means[3 * index]).cast<double>();
  const Eigen::Vector3d log_scale =
      Eigen::Vector3f::Map(&model.log_scales[3 * index]).cast<double>();
  const float* const q = &model.rotations[4 * index];
  Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(rotation.squaredNorm() > 1e-20)) return std::nullopt;
  rotation.normalize();

  // In this frame the Gaussian is a ball. The size of the ball cancels in t, so
  // lengths are divided by the largest standard deviation and nothing
  // overflows.
  const double largest = log_scale.maxCoeff();
  const Eigen::Array3d scale =
      (log_scale.array() - largest).exp().max(kMinFlatness);
  const Eigen::Vector3d offset = mean - origin;
  const Eigen::Matrix3d to_axes = rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d along = (to_axes * direction).array() / scale;
  const Eigen::Vector3d to_mean = (to_axes * offset).array() / scale;
  const double middle = along.dot(to_mean) / along.squaredNorm();
  const double nearest = direction.dot(offset);
  const double reach = kReach * std::exp(largest);
  if (!log_scale.allFinite() || !std::isfinite(middle) ||
      !std::isfinite(nearest)) {
    return std::nullopt;
  }
  return std::clamp(middle, nearest - reach, nearest + reach);
}

void DepthPoints::Append(const DepthPoints& other) {
  positions.insert(
      positions.end(), other.positions.begin(), other.positions.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
}

StatusOr<DepthPoints> SampleDepthPoints(const GaussianModel& model,
                                        const View& view,
                                        const ViewContributions& contributions,
                                        const ImageF& photo,
                                        double near_plane,
                                        size_t count,
                                        uint64_t seed,
                                        uint64_t stream) {
  if (!SameSize(view.camera, contributions, photo)) {
    return InvalidArgumentError(
        "camera, contributions and RGB photo of a view must be of one size");
  }
  const Eigen::Vector3d origin = CameraCentre(view.cam_from_world);
  const Eigen::Matrix3d world_from_cam =
      view.cam_from_world.rotation.toRotationMatrix().transpose();
  const int width = view.camera.width;
  const size_t num_pixels = photo.num_pixels();
  std::vector<float> depths(num_pixels);  // z in the camera frame.
  std::vector<float> chances(num_pixels, 0.0f);
  for (size_t i = 0; i < num_pixels; ++i) {
    // As an unsigned number -1 is larger than the size of any model.
    const auto dominant =
        static_cast<uint32_t>(contributions.dominant.data()[i]);
    if (dominant >= model.size()) continue;
    const Eigen::Vector3d ray =
        CameraRay(view.camera,
                  static_cast<int>(i % static_cast<size_t>(width)),
                  static_cast<int>(i / static_cast<size_t>(width)));
    const double norm = ray.norm();
    const std::optional<double> distance =
        MidpointDistance(model, dominant, origin, world_from_cam * ray / norm);
    if (!distance || !(*distance / norm >= near_plane)) continue;
    depths[i] = static_cast<float>(*distance / norm);
    chances[i] = 1.0f - contributions.transmittance.data()[i];
  }

  DepthPoints points;
  for (const uint32_t i : SampleByImportance(chances, count, seed, stream)) {
    const Eigen::Vector3d ray =
        CameraRay(view.camera,
                  static_cast<int>(i % static_cast<uint32_t>(width)),
                  static_cast<int>(i / static_cast<uint32_t>(width)));
    const float* const color = photo.data() + 3 * size_t{i};
    points.positions.push_back(origin + world_from_cam * ray *
                                            static_cast<double>(depths[i]));
    points.colors.push_back({color[0], color[1], color[2]});
  }
  return points;
}

double AccumulatedOpacity(const ViewContributions& contributions) {
  const Image<int32_t>& dominant = contributions.dominant;
  double sum = 0;
  for (size_t i = 0; i < dominant.size(); ++i) {
    if (dominant.data()[i] < 0) continue;
    sum += 1.0 - contributions.transmittance.data()[i];
  }
  return sum;
}

std::vector<size_t> PointsPerView(std::span<const double> opacity,
                                  size_t total) {
  std::vector<size_t> counts(opacity.size(), 0);
  std::vector<size_t> shown;
  double sum = 0;
  for (size_t i = 0; i < opacity.size(); ++i) {
    if (!(opacity[i] > 0 && std::isfinite(opacity[i]))) continue;
    shown.push_back(i);
    sum += opacity[i];
  }
  if (shown.empty()) return counts;

  size_t left = total;
  std::vector<double> remainders(opacity.size(), 0.0);
  for (const size_t i : shown) {
    const double quota = static_cast<double>(total) * (opacity[i] / sum);
    counts[i] = std::min(left, static_cast<size_t>(quota));
    left -= counts[i];
    remainders[i] = quota - static_cast<double>(counts[i]);
  }
  std::stable_sort(shown.begin(), shown.end(), [&](size_t a, size_t b) {
    return remainders[a] > remainders[b];
  });
  // But for rounding, fewer points than views are left.
  for (size_t k = 0; left > 0; ++k, --left) ++counts[shown[k % shown.size()]];
  return counts;
}

StatusOr<GaussianModel> RestartFromDepthPoints(
    const DepthPoints& points,
    double scene_extent,
    const InitializationOptions& options) {
  std::vector<std::array<float, 3>> sh_dc = points.colors;
  for (std::array<float, 3>& color : sh_dc) {
    for (float& value : color) value = (value - 0.5f) / kShC0;
  }
  return InitializeFromShDc(points.positions, sh_dc, scene_extent, options);
}

}  // namespace freegs::splat
