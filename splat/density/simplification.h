// SPDX-License-Identifier: BSD-3-Clause
// Fewer Gaussians for the same scene, chosen by importance (Fang and Wang 2024,
// Mini-Splatting, section 4.2). What counts as important: splat/density/importance.h.

#ifndef FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_
#define FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/scene/initialization.h"

namespace freegs::splat {

// In both functions an importance that is negative or not finite counts as 0,
// and Gaussians of importance 0 are never chosen. Indices come out ascending.

// Draws `count` indices without replacement, each draw with a probability
// proportional to importance among those left (the exponential keys of
// Efraimidis and Spirakis 2006). All that have importance when they are no more
// than `count`. Random numbers are a function of (seed, stream, index).
// Sampling keeps some of the less important, where taking the most important
// would leave holes.
std::vector<uint32_t> SampleByImportance(std::span<const float> importance,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t stream);

// The fewest Gaussians, the most important ones (ties by index), that together
// carry at least `share` of the total importance. All that have importance for
// a share of 1 or more, none for 0 or less. Mini-Splatting's last pruning keeps
// 0.99.
std::vector<uint32_t> KeepCumulativeImportance(
    std::span<const float> importance, double share);

// The `count` most important (ties by index), or all that have importance when
// they are no more.
std::vector<uint32_t> MostImportant(std::span<const float> importance,
                                    size_t count);

// Starts afresh from the Gaussians listed: position and colour of degree 0 stay
// to the last bit, the rest is set as InitializeFromPoints sets it (opacity,
// isotropic scale from the neighbours among those kept, no rotation, no
// coefficients above degree 0). Gaussians whose position or colour is not
// finite are left out. kInvalidArgument for an index outside the model,
// kBadInput when nothing remains.
StatusOr<GaussianModel> RestartFromMeans(
    const GaussianModel& model,
    std::span<const uint32_t> kept,
    double scene_extent,
    const InitializationOptions& options = {});

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_
