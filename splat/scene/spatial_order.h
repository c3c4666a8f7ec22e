// SPDX-License-Identifier: BSD-3-Clause
// An order of the Gaussians in which neighbours in space are neighbours in
// memory.

#ifndef FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_
#define FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_

#include <cstdint>
#include <vector>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// The indices of all Gaussians along a Morton curve through the middle 96 % of
// their means (the others at its faces); ties, and means that are not finite,
// by index. Views see contiguous parts of a scene, so that what a step touches
// then lies together.
std::vector<uint32_t> MortonOrder(const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_
