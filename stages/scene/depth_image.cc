// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/depth_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/quantile.h"
#include "stages/scene/heat_map.h"

namespace freegs::stages {

DepthRange VisibleDepthRange(const splat::GaussianModel& model,
                             std::span<const View> views) {
  std::vector<float> depths;
  // About a million samples are enough for two quantiles.
  const size_t stride =
      std::max<size_t>(1, model.size() * views.size() / 1'000'000);
  size_t offset = 0;
  for (const View& view : views) {
    for (size_t i = offset++ % stride; i < model.size(); i += stride) {
      const Eigen::Vector3d mean =
          Eigen::Map<const Eigen::Vector3f>(&model.means[3 * i]).cast<double>();
      const Eigen::Vector3d point = view.cam_from_world * mean;
      if (point.z() <= 0) continue;
      const Pinhole& camera = view.camera;
      const double x = camera.fx * point.x() / point.z() + camera.cx;
      const double y = camera.fy * point.y() / point.z() + camera.cy;
      if (x >= 0 && y >= 0 && x < camera.width && y < camera.height) {
        depths.push_back(static_cast<float>(point.z()));
      }
    }
  }
  if (depths.empty()) return {};
  return {LowerQuantile(depths, 0.001), LowerQuantile(depths, 0.999)};
}

double DepthUnit(double far) {
  if (!(far > 0) || !std::isfinite(far)) return 0.001;
  return std::pow(10.0, std::ceil(std::log10(far / 65535.0)));
}

ImageU16 EncodeDepth(const ImageF& depth, double unit) {
  ImageU16 encoded(depth.width(), depth.height(), 1);
  std::transform(depth.data(),
                 depth.data() + depth.size(),
                 encoded.data(),
                 [unit](float z) {
                   const double nearest = z > 0 ? 1 : 0;
                   const double steps = std::clamp(z / unit, nearest, 65535.0);
                   return static_cast<uint16_t>(std::lround(steps));
                 });
  return encoded;
}

ImageU8 ColorDepth(const ImageF& depth, const DepthRange& range) {
  const ColorScale inferno = InfernoScale();
  const double near = std::max(range.near, 1e-9);
  const double far = std::max(range.far, 1.0001 * near);
  const double span = 1 / near - 1 / far;
  ImageU8 color(depth.width(), depth.height(), 3);
  for (size_t k = 0; k < depth.num_pixels(); ++k) {
    const double z = depth.data()[k];
    if (!(z > 0)) continue;
    const double nearness = (1 / z - 1 / far) / span;
    // The darkest tenth of the ramp is left out, so that far things differ from
    // black, which means nothing.
    const auto index = static_cast<size_t>(
        std::lround(25 + 230 * std::clamp(nearness, 0.0, 1.0)));
    std::copy(
        inferno[index].begin(), inferno[index].end(), color.data() + 3 * k);
  }
  return color;
}

}  // namespace freegs::stages
