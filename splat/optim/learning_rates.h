// SPDX-License-Identifier: BSD-3-Clause
// The learning rates of 3D Gaussian Splatting by kind of parameter and
// iteration.

#ifndef FREEGS_SPLAT_OPTIM_LEARNING_RATES_H_
#define FREEGS_SPLAT_OPTIM_LEARNING_RATES_H_

#include <array>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Indexed by static_cast<int>(Parameter).
using LearningRates = std::array<float, kNumParameters>;

// The defaults are those of Kerbl et al. 2023.
struct LearningRateOptions {
  // Rate of the positions at the first step, and from the end of the decay on,
  // in units of the model frame per unit of scene extent.
  double mean_initial = 1.6e-4;
  double mean_final = 1.6e-6;

  // Number of iterations over which it decays exponentially.
  int mean_decay_steps = 30000;

  // The other rates stay the same, in the units in which the model stores the
  // parameters.
  double log_scale = 5e-3;
  double rotation = 1e-3;
  double opacity_logit = 0.05;
  double sh_dc = 2.5e-3;
  double sh_rest = 2.5e-3 / 20;

  Status Check() const;
};

// Returns the rates of an iteration, which may be fractional or past the end of
// the decay. `scene_extent` is in units of the model frame, see SceneExtent.
LearningRates LearningRatesAt(const LearningRateOptions& options,
                              double scene_extent,
                              double iteration);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_LEARNING_RATES_H_
