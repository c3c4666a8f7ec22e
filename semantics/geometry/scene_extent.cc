// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/scene_extent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/quantile.h"
#include "splat/render/renderer.h"

namespace freegs::semantics {
namespace {

constexpr size_t kMaxViews = 48;
constexpr int kThumbnailSide = 96;  // Pixels.

}  // namespace

SceneExtent ComputeSceneExtent(std::span<const float> positions) {
  SceneExtent extent;
  const size_t count = positions.size() / 3;
  if (count == 0) return extent;
  std::vector<double> values(count);
  for (int k = 0; k < 3; ++k) {
    for (size_t i = 0; i < count; ++i) values[i] = positions[i * 3 + k];
    extent.centre[k] = UpperMedian(values);
  }
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d x(
        positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]);
    values[i] = (x - extent.centre).norm();
  }
  const double radius = UpperMedian(values);
  if (radius > 0 && std::isfinite(radius)) extent.radius = radius;
  return extent;
}

SceneExtent ComputeSceneExtent(const splat::GaussianModel& model,
                               std::span<const View> views,
                               double min_opacity,
                               ThreadPool& pool) {
  std::array<std::vector<double>, 3> coordinates;
  std::vector<double> depths;
  const size_t step = views.size() / kMaxViews + 1;
  for (size_t i = 0; i < views.size(); i += step) {
    const View& view = views[i];
    const Pinhole camera = view.camera.LimitedTo(kThumbnailSide);
    splat::RenderOptions options;
    options.sh_degree = 0;
    const splat::RenderedView rendered =
        splat::RenderView(model, camera, view.cam_from_world, options, pool);
    const Rigid3d world_from_cam = Inverse(view.cam_from_world);
    for (int y = camera.height / 4; y < camera.height * 3 / 4; ++y) {
      for (int x = camera.width / 4; x < camera.width * 3 / 4; ++x) {
        const double depth = rendered.depth(x, y);
        if (!(rendered.transmittance(x, y) < 0.5) || !(depth > 0) ||
            !std::isfinite(depth)) {
          continue;
        }
        const Eigen::Vector3d point =
            world_from_cam *
            Eigen::Vector3d((x + 0.5 - camera.cx) / camera.fx * depth,
                            (y + 0.5 - camera.cy) / camera.fy * depth,
                            depth);
        for (int k = 0; k < 3; ++k) coordinates[k].push_back(point[k]);
        depths.push_back(depth);
      }
    }
  }
  if (!depths.empty()) {
    SceneExtent extent;
    for (int k = 0; k < 3; ++k) extent.centre[k] = UpperMedian(coordinates[k]);
    extent.radius = UpperMedian(depths) / 2;
    return extent;
  }
  std::vector<float> positions;
  for (size_t i = 0; i < model.size(); ++i) {
    if (splat::Opacity(model, i) < min_opacity) continue;
    const float* mean = model.means.data() + i * 3;
    if (std::all_of(mean, mean + 3, [](float x) { return std::isfinite(x); })) {
      positions.insert(positions.end(), mean, mean + 3);
    }
  }
  return ComputeSceneExtent(positions);
}

}  // namespace freegs::semantics
