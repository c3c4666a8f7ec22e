// SPDX-License-Identifier: BSD-3-Clause
// An order of the Gaussians in which neighbours in space are neighbours in
// memory.

#ifndef FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_
#define FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_

#include <cstdint>
#include <vector>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Returns the indices of all Gaussians in the order of a Morton curve. The
// curve fills the box that holds the middle 96 % of the means along each axis;
// Gaussians outside count as lying on its faces. Gaussians in one cell of the
// curve follow each other by index. Those whose mean is not finite may be
// anywhere.
//
// A view shows a contiguous part of the scene, so in this order the parameters
// that a training step touches lie close together in memory.
std::vector<uint32_t> MortonOrder(const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPATIAL_ORDER_H_
