// SPDX-License-Identifier: BSD-3-Clause
// Gives labels to the points that clustering left without one.

#ifndef FREEGS_SEMANTICS_INSTANCES_LABEL_NOISE_H_
#define FREEGS_SEMANTICS_INSTANCES_LABEL_NOISE_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// A point with label -1 takes the label of the nearest point that has one, if
// that point is within `distance`. positions: N x 3. labels: N; changed in
// place.
void LabelNoise(std::span<const float> positions,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels);

// Labels noise in the same way among Gaussians, by their means. One that is not
// finite finds no neighbour, and nobody finds it.
void LabelNoise(const splat::GaussianModel& model,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_LABEL_NOISE_H_
