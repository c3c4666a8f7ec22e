// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/camera_clearance.h"

#include <algorithm>
#include <cmath>

#include "core/quantile.h"
#include "core/rigid3d.h"

namespace freegs::splat {
namespace {

constexpr int64_t kGaussianGrain = 4096;

// Distances from the camera of the points that its picture shows.
void VisibleDistances(const View& view,
                      const GaussianModel& points,
                      std::vector<float>* distances) {
  distances->clear();
  const Eigen::Matrix3d rotation =
      view.cam_from_world.rotation.toRotationMatrix();
  const Pinhole& camera = view.camera;
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d point =
        rotation *
            Eigen::Vector3f::Map(&points.means[3 * i]).cast<double>().eval() +
        view.cam_from_world.translation;
    if (!(point.z() > 0)) continue;
    const double x = camera.fx * point.x() / point.z() + camera.cx;
    const double y = camera.fy * point.y() / point.z() + camera.cy;
    if (!(x >= 0 && x < camera.width && y >= 0 && y < camera.height)) continue;
    distances->push_back(static_cast<float>(point.norm()));
  }
}

}  // namespace

Status CameraClearanceOptions::Check() const {
  if (!(factor >= 0 && factor < 1)) {
    return InvalidArgumentError("the clearance factor must be in [0, 1)");
  }
  if (!(near_quantile >= 0 && near_quantile <= 1)) {
    return InvalidArgumentError("near_quantile must be in [0, 1]");
  }
  return Status();
}

std::vector<ClearBall> ClearBalls(const CameraClearanceOptions& options,
                                  std::span<const View> views,
                                  const GaussianModel& points,
                                  ThreadPool& pool) {
  if (options.factor == 0) return {};
  std::vector<ClearBall> balls(views.size());
  pool.ParallelFor(
      0,
      static_cast<int64_t>(views.size()),
      1,
      [&](int64_t begin, int64_t end, int) {
        std::vector<float> distances;
        for (int64_t v = begin; v < end; ++v) {
          VisibleDistances(views[v], points, &distances);
          if (distances.empty()) continue;
          balls[v].centre = CameraCentre(views[v].cam_from_world).cast<float>();
          balls[v].radius = static_cast<float>(
              options.factor * LowerQuantile(distances, options.near_quantile));
        }
      });
  std::erase_if(balls, [](const ClearBall& ball) {
    return !(ball.radius > 0 && std::isfinite(ball.radius) &&
             ball.centre.allFinite());
  });
  return balls;
}

std::vector<uint32_t> OutsideBalls(std::span<const ClearBall> balls,
                                   const GaussianModel& model,
                                   ThreadPool& pool) {
  std::vector<uint8_t> inside(model.size(), 0);
  pool.ParallelFor(
      0,
      static_cast<int64_t>(model.size()),
      kGaussianGrain,
      [&](int64_t begin, int64_t end, int) {
        for (const ClearBall& ball : balls) {
          const float limit = ball.radius * ball.radius;
          for (int64_t i = begin; i < end; ++i) {
            const auto mean = Eigen::Vector3f::Map(&model.means[3 * i]);
            inside[i] |= (mean - ball.centre).squaredNorm() < limit ? 1 : 0;
          }
        }
      });
  std::vector<uint32_t> outside;
  outside.reserve(model.size());
  for (size_t i = 0; i < inside.size(); ++i) {
    if (inside[i] == 0) outside.push_back(static_cast<uint32_t>(i));
  }
  return outside;
}

}  // namespace freegs::splat
