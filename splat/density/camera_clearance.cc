// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/camera_clearance.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/quantile.h"
#include "core/random.h"
#include "core/rigid3d.h"

namespace freegs::splat {
namespace {

constexpr int64_t kGaussianGrain = 4096;

// Distances from the camera of the points that its picture shows. Of more than
// kMaxClearancePoints points an even sample is looked at.
void VisibleDistances(const View& view,
                      const GaussianModel& points,
                      std::vector<float>* distances) {
  distances->clear();
  const Eigen::Matrix3d rotation =
      view.cam_from_world.rotation.toRotationMatrix();
  const Pinhole& camera = view.camera;
  const size_t count = std::min(points.size(), kMaxClearancePoints);
  for (size_t k = 0; k < count; ++k) {
    const size_t i = k * points.size() / count;
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

// Finds the balls that may hold a point. Space is divided into cubes, and each
// cube has a place in a table of fixed size. A place lists the balls that touch
// its cubes. Where cubes share a place, or the box around a ball is larger than
// the ball, the list has balls that are not near; the caller looks at each of
// them. No ball that holds the point is missing.
class NearBalls {
 public:
  // There must be balls, finite ones with radii above 0.
  explicit NearBalls(std::span<const ClearBall> balls) {
    double cubed_radii = 0;
    for (const ClearBall& ball : balls) {
      cubed_radii += std::pow(static_cast<double>(ball.radius), 3);
    }
    // A cube has the mean volume of the boxes around the balls. So a ball
    // touches about 8 cubes at most on average, however different the sizes of
    // the balls are.
    side_ = 2 * std::cbrt(cubed_radii / static_cast<double>(balls.size()));
    mask_ = std::bit_ceil(16 * balls.size()) - 1;
    begins_.assign(mask_ + 2, 0);
    // First counts the balls of each place, then lists them.
    for (const ClearBall& ball : balls) {
      ForEachPlace(ball, [this](size_t place) { ++begins_[place]; });
    }
    std::inclusive_scan(begins_.begin(), begins_.end(), begins_.begin());
    listed_.resize(begins_.back());
    for (const ClearBall& ball : balls) {
      ForEachPlace(ball,
                   [&](size_t place) { listed_[--begins_[place]] = ball; });
    }
  }

  // A point that is not finite has none.
  std::span<const ClearBall> At(const Eigen::Vector3f& point) const {
    if (!point.allFinite()) return {};
    const size_t place =
        PlaceOf({CubeOf(point.x()), CubeOf(point.y()), CubeOf(point.z())});
    return std::span(listed_).subspan(begins_[place],
                                      begins_[place + 1] - begins_[place]);
  }

 private:
  // The limit keeps far coordinates in the range of the integers.
  int64_t CubeOf(double coordinate) const {
    return static_cast<int64_t>(
        std::clamp(std::floor(coordinate / side_), -0x1p62, 0x1p62));
  }

  size_t PlaceOf(const std::array<int64_t, 3>& cube) const {
    uint64_t bits = 0;
    for (const int64_t at : cube) {
      bits = MixBits(bits ^ static_cast<uint64_t>(at));
    }
    return bits & mask_;
  }

  // Distances from a ball are compared in float, so a point that counts as
  // inside may lie outside by a rounding error. The box is larger by more.
  template <typename Fn>
  void ForEachPlace(const ClearBall& ball, const Fn& fn) const {
    constexpr double kRounding = 1e-6;
    const double reach = (1 + kRounding) * ball.radius;
    std::array<int64_t, 3> first, last, cube;
    for (int k = 0; k < 3; ++k) {
      first[k] = CubeOf(ball.centre[k] - reach);
      last[k] = CubeOf(ball.centre[k] + reach);
    }
    for (cube[0] = first[0]; cube[0] <= last[0]; ++cube[0]) {
      for (cube[1] = first[1]; cube[1] <= last[1]; ++cube[1]) {
        for (cube[2] = first[2]; cube[2] <= last[2]; ++cube[2]) {
          fn(PlaceOf(cube));
        }
      }
    }
  }

  double side_ = 1;  // How long the edges of a cube are.
  size_t mask_ = 0;  // The number of places, a power of two, less one.
  // The balls of place p are those from begins_[p] to begins_[p + 1].
  std::vector<uint32_t> begins_;
  std::vector<ClearBall> listed_;
};

bool Holds(const ClearBall& ball, const Eigen::Vector3f& point) {
  return (point - ball.centre).squaredNorm() < ball.radius * ball.radius;
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
  if (!balls.empty()) {
    const NearBalls near(balls);
    pool.ParallelFor(0,
                     static_cast<int64_t>(model.size()),
                     kGaussianGrain,
                     [&](int64_t begin, int64_t end, int) {
                       for (int64_t i = begin; i < end; ++i) {
                         const Eigen::Vector3f mean =
                             Eigen::Vector3f::Map(&model.means[3 * i]);
                         inside[i] = std::ranges::any_of(
                             near.At(mean), [&](const ClearBall& ball) {
                               return Holds(ball, mean);
                             });
                       }
                     });
  }
  std::vector<uint32_t> outside;
  outside.reserve(model.size());
  for (size_t i = 0; i < inside.size(); ++i) {
    if (inside[i] == 0) outside.push_back(static_cast<uint32_t>(i));
  }
  return outside;
}

}  // namespace freegs::splat
