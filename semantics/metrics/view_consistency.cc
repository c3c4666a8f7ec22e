// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/view_consistency.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace freegs::semantics {
namespace {

using Eigen::Vector3d;

struct MaskCounts {
  int64_t from = 0;
  int64_t to = 0;
  int64_t both = 0;
};

Status CheckSizes(const LabelledView& view) {
  const Pinhole& camera = view.view.camera;
  const auto fits = [&camera](const auto& image) {
    return image.width() == camera.width && image.height() == camera.height &&
           image.channels() == 1;
  };
  if (fits(view.labels) && fits(view.depth)) return Status();
  return InvalidArgumentError(view.view.name +
                              ": labels or depth are not of the camera's size");
}

// The label of `to` at the pixel where it sees `point`, which is given in the
// camera frame of `to`. Nothing if it does not see the point.
std::optional<int32_t> LabelSeen(const LabelledView& to,
                                 const Vector3d& point,
                                 double tolerance) {
  const Pinhole& camera = to.view.camera;
  if (!(point.z() > 0)) return std::nullopt;
  const double u = camera.fx * point.x() / point.z() + camera.cx;
  const double v = camera.fy * point.y() / point.z() + camera.cy;
  if (!(u >= 0 && u < camera.width && v >= 0 && v < camera.height)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const double depth = to.depth(x, y);
  if (!(depth > 0 && std::abs(point.z() - depth) <= tolerance * depth)) {
    return std::nullopt;
  }
  return to.labels(x, y);
}

}  // namespace

Status ViewConsistencyOptions::Check() const {
  if (!(depth_tolerance > 0 && depth_tolerance < 1)) {
    return InvalidArgumentError("depth_tolerance must be in (0, 1)");
  }
  if (min_pixels < 1) {
    return InvalidArgumentError("min_pixels must be at least 1");
  }
  return Status();
}

StatusOr<std::map<int, double>> CompareViews(
    const LabelledView& from,
    const LabelledView& to,
    const ViewConsistencyOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckSizes(from));
  FREEGS_RETURN_IF_ERROR(CheckSizes(to));
  const Pinhole& camera = from.view.camera;
  const Rigid3d to_from_from =
      to.view.cam_from_world * Inverse(from.view.cam_from_world);
  std::map<int, MaskCounts> counts;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double depth = from.depth(x, y);
      if (!(depth > 0)) continue;
      const Vector3d point((x + 0.5 - camera.cx) / camera.fx * depth,
                           (y + 0.5 - camera.cy) / camera.fy * depth,
                           depth);
      const std::optional<int32_t> seen =
          LabelSeen(to, to_from_from * point, options.depth_tolerance);
      if (!seen) continue;
      const int32_t label = from.labels(x, y);
      if (label >= 0) ++counts[label].from;
      if (*seen >= 0) ++counts[*seen].to;
      if (label >= 0 && label == *seen) ++counts[label].both;
    }
  }
  std::map<int, double> ious;
  for (const auto& [instance, count] : counts) {
    const int64_t either = count.from + count.to - count.both;
    if (either < options.min_pixels) continue;
    ious[instance] =
        static_cast<double>(count.both) / static_cast<double>(either);
  }
  return ious;
}

std::vector<std::pair<size_t, size_t>> NeighbouringViews(
    const std::vector<View>& views) {
  constexpr double kMinCosine = 0.5;
  std::set<std::pair<size_t, size_t>> pairs;
  for (size_t i = 0; i < views.size(); ++i) {
    const Rigid3d& pose = views[i].cam_from_world;
    const Vector3d axis = pose.rotation.conjugate() * Vector3d::UnitZ();
    std::optional<size_t> nearest;
    double best = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < views.size(); ++j) {
      const Rigid3d& other = views[j].cam_from_world;
      const Vector3d other_axis =
          other.rotation.conjugate() * Vector3d::UnitZ();
      if (j == i || axis.dot(other_axis) < kMinCosine) continue;
      const double distance =
          (CameraCentre(pose) - CameraCentre(other)).squaredNorm();
      if (distance < best) {
        best = distance;
        nearest = j;
      }
    }
    if (nearest) pairs.insert(std::minmax(i, *nearest));
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace freegs::semantics
