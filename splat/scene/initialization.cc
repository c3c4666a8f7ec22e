// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/initialization.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <flann/flann.hpp>

#include "core/quantile.h"

namespace freegs::splat {
namespace {

using Point = std::array<float, 3>;

// The coefficient of a colour of 1/255. A colour below 0 counts as 0 and has no
// gradient, and rounding can make one of a pure 0, which would stay black: so
// would a model without colours.
constexpr float kDarkest = (1.0f / 255.0f - 0.5f) / kShC0;

// The points that are finite as floats, by index.
std::vector<size_t> FiniteIndices(std::span<const Eigen::Vector3d> positions,
                                  std::span<const Point> colors) {
  std::vector<size_t> finite;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (positions[i].cast<float>().allFinite() &&
        Eigen::Vector3f::Map(colors[i].data()).allFinite()) {
      finite.push_back(i);
    }
  }
  return finite;
}

// The distinct points, and for each input the distinct point that it is.
struct DistinctPoints {
  std::vector<Point> points;
  std::vector<size_t> index;  // Per input.
};

DistinctPoints Distinct(const std::vector<Point>& points) {
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return points[a] < points[b];
  });
  DistinctPoints distinct;
  distinct.index.resize(points.size());
  for (const size_t i : order) {
    if (distinct.points.empty() || distinct.points.back() != points[i]) {
      distinct.points.push_back(points[i]);
    }
    distinct.index[i] = distinct.points.size() - 1;
  }
  return distinct;
}

// Root mean square distance of each point to its nearest others; empty for a
// single point.
std::vector<double> NeighbourDistances(std::vector<Point>& points,
                                       int num_neighbours) {
  const size_t others =
      std::min<size_t>(points.size() - 1, static_cast<size_t>(num_neighbours));
  if (others == 0) return {};
  const flann::Matrix<float> data(points[0].data(), points.size(), 3);
  flann::KDTreeSingleIndex<flann::L2_3D<float>> index(data);
  index.buildIndex();

  // The first neighbour is the point itself, because all points are distinct.
  const size_t k = others + 1;
  std::vector<size_t> indices(points.size() * k);
  std::vector<float> squares(points.size() * k);
  flann::Matrix<size_t> indices_matrix(indices.data(), points.size(), k);
  flann::Matrix<float> squares_matrix(squares.data(), points.size(), k);
  flann::SearchParams parameters(flann::FLANN_CHECKS_UNLIMITED, 0.0f, true);
  index.knnSearch(data, indices_matrix, squares_matrix, k, parameters);
  std::vector<double> distances(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const float* const row = &squares[i * k];
    distances[i] = std::sqrt(std::accumulate(row, row + k, 0.0) /
                             static_cast<double>(others));
  }
  return distances;
}

}  // namespace

Status InitializationOptions::Check() const {
  if (!(opacity > 0 && opacity < 1)) {
    return InvalidArgumentError("the initial opacity must be in (0, 1)");
  }
  if (num_neighbours < 1) {
    return InvalidArgumentError("num_neighbours must be >= 1");
  }
  if (!(min_scale > 0 && min_scale <= max_scale && std::isfinite(max_scale))) {
    return InvalidArgumentError(
        "initial scales must be bounded by 0 < min_scale <= max_scale");
  }
  if (sh_degree < 0 || sh_degree > kMaxShDegree) {
    return InvalidArgumentError("the SH degree must be from 0 to 3");
  }
  return Status();
}

StatusOr<GaussianModel> InitializeFromPoints(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<uint8_t, 3>> colors,
    double scene_extent,
    const InitializationOptions& options) {
  std::vector<std::array<float, 3>> sh_dc(colors.size());
  for (size_t i = 0; i < colors.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const float color = static_cast<float>(colors[i][channel]) / 255.0f;
      sh_dc[i][channel] = (color - 0.5f) / kShC0;
    }
  }
  return InitializeFromShDc(positions, sh_dc, scene_extent, options);
}

StatusOr<GaussianModel> InitializeFromShDc(
    std::span<const Eigen::Vector3d> positions,
    std::span<const std::array<float, 3>> sh_dc,
    double scene_extent,
    const InitializationOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (positions.size() != sh_dc.size()) {
    return InvalidArgumentError("there must be one colour per point");
  }
  if (!(scene_extent > 0 && std::isfinite(scene_extent))) {
    return InvalidArgumentError("the scene extent must be > 0");
  }
  const std::vector<size_t> finite = FiniteIndices(positions, sh_dc);
  if (finite.empty()) {
    return BadInputError("no 3D points to start the Gaussians from");
  }
  // The points are moved to their centre first: far from the origin,
  // differences of floats are coarse. The centre is the median of each
  // coordinate, which lies among the points however far away some of them are.
  Eigen::Vector3d centre;
  std::vector<double> coordinates(finite.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(finite, coordinates.begin(), [&](size_t i) {
      return positions[i][axis];
    });
    centre[axis] = UpperMedian(coordinates);
  }
  std::vector<Point> points(finite.size());
  for (size_t k = 0; k < finite.size(); ++k) {
    const Eigen::Vector3f p = (positions[finite[k]] - centre).cast<float>();
    points[k] = {p.x(), p.y(), p.z()};
  }
  DistinctPoints distinct = Distinct(points);
  const std::vector<double> distances =
      NeighbourDistances(distinct.points, options.num_neighbours);

  GaussianModel model;
  model.sh_degree = options.sh_degree;
  model.Resize(finite.size());
  const double lowest = options.min_scale * scene_extent;
  const double highest = options.max_scale * scene_extent;
  const float logit =
      static_cast<float>(std::log(options.opacity / (1 - options.opacity)));
  for (size_t k = 0; k < finite.size(); ++k) {
    // A point without neighbours gets a hundredth of the scene extent, the size
    // from which 3DGS splits Gaussians.
    const double distance =
        distances.empty() ? 0.01 * scene_extent : distances[distinct.index[k]];
    const float log_scale =
        static_cast<float>(std::log(std::clamp(distance, lowest, highest)));
    for (int axis = 0; axis < 3; ++axis) {
      model.means[3 * k + axis] =
          static_cast<float>(positions[finite[k]][axis]);
      model.log_scales[3 * k + axis] = log_scale;
      model.sh_dc[3 * k + axis] = std::max(kDarkest, sh_dc[finite[k]][axis]);
    }
    model.rotations[4 * k] = 1;
    model.opacity_logits[k] = logit;
  }
  return model;
}

double SceneExtent(std::span<const View> views,
                   std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : views) {
    mean +=
        CameraCentre(view.cam_from_world) / static_cast<double>(views.size());
  }
  double farthest = 0;
  for (const View& view : views) {
    farthest =
        std::max(farthest, (CameraCentre(view.cam_from_world) - mean).norm());
  }
  std::vector<double> distances;
  for (const Eigen::Vector3d& point : points) {
    const double distance = (point - mean).norm();
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  const double median = UpperMedian(std::move(distances));
  // The cameras coincide, but for rounding, when their spread is tiny beside
  // the distance of the points.
  if (farthest > 1e-6 * median && farthest > 0) return 1.1 * farthest;
  return median > 0 ? median : 1.0;
}

}  // namespace freegs::splat
