// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/box_iou.h"

#include <algorithm>

#include <Eigen/Core>

namespace freegs::semantics {

double Volume(const AxisAlignedBox& box) {
  return (box.max - box.min).cwiseMax(0.0).prod();
}

double BoxIou(const AxisAlignedBox& a, const AxisAlignedBox& b) {
  const double both = Volume({a.min.cwiseMax(b.min), a.max.cwiseMin(b.max)});
  const double all = Volume(a) + Volume(b) - both;
  return all > 0 ? std::clamp(both / all, 0.0, 1.0) : 0;
}

}  // namespace freegs::semantics
